//! NumPy files and archives, byte by byte: headers, stored types, axis orders.

/// A file of format `version` with this header text and data.
pub fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

pub fn dict(descr: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
}

/// A stored type: its description, and a value as its bytes.
pub type Stored = (&'static str, fn(f64) -> Vec<u8>);

pub const STORED: [Stored; 18] = [
    ("'<f2'", |v| {
        npyz::half::f16::from_f64(v)
            .to_bits()
            .to_le_bytes()
            .to_vec()
    }),
    ("'>f2'", |v| {
        npyz::half::f16::from_f64(v)
            .to_bits()
            .to_be_bytes()
            .to_vec()
    }),
    ("'<f4'", |v| (v as f32).to_le_bytes().to_vec()),
    ("'>f4'", |v| (v as f32).to_be_bytes().to_vec()),
    ("'<f8'", |v| v.to_le_bytes().to_vec()),
    ("'>f8'", |v| v.to_be_bytes().to_vec()),
    ("'|u1'", |v| vec![v as u8]),
    ("'|b1'", |v| vec![u8::from(v > 100.0)]),
    ("'|i1'", |v| vec![v as u8 / 2]),
    ("'<u2'", |v| (v as u16).to_le_bytes().to_vec()),
    ("'>u2'", |v| (v as u16).to_be_bytes().to_vec()),
    ("'<i2'", |v| (v as i16).to_le_bytes().to_vec()),
    ("'>i2'", |v| (v as i16).to_be_bytes().to_vec()),
    ("'<u4'", |v| (v as u32).to_le_bytes().to_vec()),
    ("'>i4'", |v| (v as i32).to_be_bytes().to_vec()),
    ("'<i4'", |v| (v as i32).to_le_bytes().to_vec()),
    ("'>u8'", |v| (v as u64).to_be_bytes().to_vec()),
    ("'<i8'", |v| (v as i64).to_le_bytes().to_vec()),
];

/// The number that a value of 0…255 is stored as.
pub fn kept(stored: &Stored, value: u32) -> f32 {
    match stored.0 {
        "'|b1'" => f32::from(u8::from(value > 100)),
        "'|i1'" => (value / 2) as f32,
        _ => value as f32,
    }
}

/// An archive of arrays, as `numpy.savez` or `numpy.savez_compressed` writes it.
pub fn npz(arrays: &[(&str, &[u8])], deflate: bool) -> Vec<u8> {
    use std::io::Write;
    let mut bytes = Vec::new();
    let mut archive = rawzip::ZipArchiveWriter::new(&mut bytes);
    for (name, data) in arrays {
        let method = match deflate {
            true => rawzip::CompressionMethod::DEFLATE,
            false => rawzip::CompressionMethod::STORE,
        };
        let file = archive.new_file(name).compression_method(method);
        let (mut entry, config) = file.start().unwrap();
        let descriptor = if deflate {
            let encoder = flate2::write::DeflateEncoder::new(&mut entry, Default::default());
            let mut writer = config.wrap(encoder);
            writer.write_all(data).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            descriptor
        } else {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(data).unwrap();
            writer.finish().unwrap().1
        };
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

/// Value 0…255 at array index `[a][b][c]`, before conversion to a stored type.
pub fn value_at([a, b, c]: [u32; 3], seed: u32) -> u32 {
    let mixed = (a * 36 + b * 6 + c).wrapping_mul(2_654_435_761);
    mixed.wrapping_add(seed) >> 24
}

/// The data of an array whose axes change in this order, slowest first.
pub fn data_in_order(
    stored: &Stored,
    shape: [u32; 3],
    [slow, middle, fast]: [usize; 3],
    seed: u32,
) -> Vec<u8> {
    let mut data = Vec::new();
    let mut index = [0; 3];
    for i in 0..shape[slow] {
        for j in 0..shape[middle] {
            for k in 0..shape[fast] {
                (index[slow], index[middle], index[fast]) = (i, j, k);
                data.extend(stored.1(f64::from(value_at(index, seed))));
            }
        }
    }
    data
}
