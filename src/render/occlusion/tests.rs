//! Every parameter applies exactly where it changes V at some depth of some column.

use super::rounding::Rounding;
use super::twin::{Column, ColumnRules, LightRay, LookUp, Twin};
use super::{MethodSetup, REGISTRY};
use crate::param::{Applies, ParamKind, ParamSpec, ParamValue, Params};

/// Parameters that act between texels, so that a single column does not depend on them, or between the samples of a
/// column, so that not every method does.
const OF_THE_MAP: &[&str] = &[
    "resolution",
    "lookup",
    "fit",
    "warp_exponent",
    "cascades",
    "cascade_ratio",
    "placement",
    "column_end",
    "near_steps",
    "near_m",
    "fill_frames",
    "blur_texels",
];

/// A light ray of 3 km through cells of 37 m, some of them empty.
struct Way {
    /// Largest extinction, m⁻¹.
    dense_per_m: f64,
}

impl LightRay for Way {
    fn length_m(&self) -> f64 {
        3001.7
    }

    fn extinction_per_m(&self, s_m: f64) -> f64 {
        let cell = (s_m / 37.0).floor();
        let noise = (cell * 12.9898).sin() * 43_758.547;
        let noise = noise - noise.floor();
        if cell < 9.0 || noise < 0.3 {
            0.0
        } else {
            self.dense_per_m * noise
        }
    }
}

/// V at several depths of a thin, a dense and an opaque [`Way`], bit for bit.
fn answers(setup: &MethodSetup) -> Vec<u64> {
    let ways = [0.004, 0.2, 30.0].map(|dense_per_m| Way { dense_per_m });
    ways.iter().flat_map(|way| along(way, setup)).collect()
}

fn along(way: &Way, setup: &MethodSetup) -> Vec<u64> {
    let params = &setup.params;
    let values: Vec<f64> = match setup.method.oracle(params).unwrap() {
        Twin::March(march) => vec![march.transmittance(way, 0.3)],
        Twin::Map(map) => {
            let rounding = Rounding {
                storage: setup.stored_format().unwrap().unwrap(),
                ..Rounding::device("f32", false)
            };
            let rules = ColumnRules::new(params).unwrap();
            let column = Column::march(way, &rules, None, 3917.3);
            let stored = map.stored(map.encode(&column, &rounding), &rounding);
            let at = |depth| LookUp {
                depth,
                length: 3001.7 / 3917.3,
                depth_m: 3917.3,
            };
            let depths = (0..12).map(|k| f64::from(k) * 0.06);
            depths
                .map(|depth| map.transmittance(&stored, at(depth), &rounding))
                .collect()
        }
    };
    values.into_iter().map(f64::to_bits).collect()
}

fn others(spec: &ParamSpec) -> Vec<ParamValue> {
    match spec.kind {
        ParamKind::Int { min, max, default } => {
            let other = if min == default { max } else { min };
            vec![ParamValue::Int(other), ParamValue::Int(default)]
        }
        ParamKind::Float { default, .. } => vec![ParamValue::Float(0.4 * default)],
        ParamKind::Choice { options, .. } => {
            options.iter().map(|o| ParamValue::Choice(o)).collect()
        }
    }
}

/// Every combination of choices, with the smallest and the default of whole numbers; columns have 20 steps.
fn settings(specs: &[&'static ParamSpec]) -> Vec<Params> {
    let mut all = vec![Params::defaults(specs.iter().copied())];
    for spec in specs.iter().filter(|s| !OF_THE_MAP.contains(&s.name)) {
        let values = match spec.kind {
            _ if spec.name == "steps" => vec![ParamValue::Int(20)],
            ParamKind::Float { .. } => continue,
            _ => others(spec),
        };
        let with = |params: &Params| {
            let each = values.iter().map(|value| {
                let mut params = params.clone();
                params.set(spec.name, *value);
                params
            });
            each.collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with).collect();
    }
    all
}

#[test]
fn a_parameter_applies_exactly_where_it_changes_what_a_method_says() {
    let mut idle = Vec::new();
    for method in REGISTRY {
        let id = method.info().id;
        let specs: Vec<&'static ParamSpec> = method.info().specs().collect();
        for params in settings(&specs) {
            let setup = MethodSetup {
                method: *method,
                params,
            };
            let own = answers(&setup);
            for spec in specs.iter().filter(|s| !OF_THE_MAP.contains(&s.name)) {
                let changes = others(spec).into_iter().any(|value| {
                    let mut other = setup.clone();
                    other.params.set(spec.name, value);
                    answers(&other) != own
                });
                let applies = spec.applies_at(&setup.params);
                assert_eq!(applies, changes, "{id} {}: {:?}", spec.name, setup.params);
                if !applies && !idle.contains(&(id, spec.name)) {
                    idle.push((id, spec.name));
                }
            }
        }
    }
    let conditional = REGISTRY.iter().flat_map(|method| {
        let info = method.info();
        let specs = info
            .specs()
            .filter(|s| s.applies != Applies::Always && !OF_THE_MAP.contains(&s.name));
        specs.map(|spec| (info.id, spec.name))
    });
    assert!(idle.contains(&("srm", "reach_m")));
    assert_eq!(idle, conditional.collect::<Vec<_>>());
}

#[test]
fn what_a_parameter_depends_on_exists_and_applies_always() {
    for method in REGISTRY {
        for spec in method.info().specs() {
            let Some(of) = spec.applies.decided_by() else {
                continue;
            };
            let deciding = method.info().specs().find(|s| s.name == of).unwrap();
            assert_eq!(deciding.applies, Applies::Always);
            let can = |value: &ParamValue| spec.applies.at(*value);
            assert!(others(deciding).iter().any(can) && !others(deciding).iter().all(can));
        }
    }
}

#[test]
fn what_does_not_apply_makes_no_other_method() {
    let setup = |pairs: &[(&str, &str)]| {
        let srm = MethodSetup::defaults("srm").unwrap();
        pairs
            .iter()
            .fold(srm, |s, (name, text)| s.with(name, text).unwrap())
    };
    let reach = [("spacing", "uniform_reach"), ("reach_m", "500")];
    assert_eq!(setup(&[("reach_m", "500")]), setup(&[]));
    assert_ne!(setup(&reach), setup(&reach[..1]));
    assert_eq!(setup(&[("reach_m", "500")]).applying().get("reach_m"), None);
    assert_eq!(
        MethodSetup::of("srm", &setup(&reach).applying()).unwrap(),
        setup(&reach)
    );
    let note = setup(&[("reach_m", "500")]).idle_note("reach_m");
    assert!(
        note.unwrap()
            .contains("applies where spacing = uniform_reach")
    );
    assert_eq!(setup(&reach).idle_note("reach_m"), None);
}
