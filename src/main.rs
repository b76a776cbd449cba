use occlab::{gpu::*,raymarch::*,occlusion::*,scene::*,batch::record::*};
fn main(){ let a:Vec<String>=std::env::args().collect();
 let mut scene:Scene=serde_json::from_str(&std::fs::read_to_string(&a[1]).unwrap()).unwrap();
 scene.validate().unwrap();
 let w:u32=a[3].parse().unwrap(); let image=ImageSize{width:w,height:w*9/16};
 let mut setup=MethodSetup::defaults(&a[2]).unwrap();
 for kv in &a[5..]{ let (k,v)=kv.split_once('=').unwrap();
   if k=="el" {scene.sun.elevation_deg=v.parse().unwrap();} else if k=="az" {scene.sun.azimuth_deg=v.parse().unwrap();} else if k=="steps_view" {scene.march.steps=v.parse().unwrap();} else {
   setup=setup.with(k,v).unwrap(); }}
 let r=Renderer::new(Gpu::new(None).unwrap());
 let t=std::time::Instant::now();
 let view=match r.view(&scene,image){Ok(v)=>v,Err(e)=>{eprintln!("{e}");std::process::exit(2)}}; eprintln!("view {:?} {:?}",t.elapsed(),view.density.built);
 let p=match r.prepare(&view,&setup){Ok(v)=>v,Err(e)=>{eprintln!("{e}");std::process::exit(2)}}; eprintln!("prep {:?} {:?}",t.elapsed(),p.memory);
 for _ in 0..2 { eprintln!("{:?}",p.run(&r.gpu,&mut unwatched).unwrap()); }
 let c=r.prepare_counting(&view,&setup).unwrap(); c.run(&r.gpu,&mut unwatched).unwrap(); eprintln!("{:?}",c.counts(&r.gpu).unwrap());
 let f=view.read(&r.gpu).unwrap();
 let mut lum:Vec<f32>=f.radiance.iter().map(|p|p[1]).collect(); lum.sort_by(f32::total_cmp);
 let ex=1.2/lum[lum.len()*99/100].max(1e-9); eprintln!("p99 {} mean sun {}",lum[lum.len()*99/100], f.sun.iter().map(|p|p[1]).sum::<f32>()/lum.len() as f32);
 let tm=|x:f32|{let x=x*ex; let y=(x*(2.51*x+0.03))/(x*(2.43*x+0.59)+0.14); (y.clamp(0.,1.).powf(1./2.2)*255.) as u8};
 let data:Vec<u8>=f.radiance.iter().flat_map(|p|[tm(p[0]),tm(p[1]),tm(p[2])]).collect();
 image::save_buffer(&a[4],&data,image.width,image.height,image::ColorType::Rgb8).unwrap();
}
