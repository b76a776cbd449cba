//! What every method says of itself.

use super::common::{exact_settings, has_map, setup};
use occlab::occlusion::{MethodSetup, REGISTRY, Role};
use std::collections::HashSet;

#[test]
fn descriptions_are_complete() {
    let mut seen = HashSet::new();
    for method in REGISTRY {
        let info = method.info();
        assert!(seen.insert(info.id), "two methods are called {}", info.id);
        assert!(
            !info.title.is_empty() && !info.citation.is_empty(),
            "{}",
            info.id
        );
        assert_eq!(info.shader, format!("occlusion/{}.wgsl", info.id));
        let mut names = HashSet::new();
        for spec in info.specs() {
            assert!(
                names.insert(spec.name),
                "{}: two parameters are called {}",
                info.id,
                spec.name
            );
            assert!(!spec.doc.is_empty());
            for printed in spec.as_printed {
                assert!(!printed.doc.is_empty(), "{}: {}", info.id, printed.option);
                assert!(spec.everyday_options().all(|o| o != printed.option));
                let value = spec.parse_text(printed.option).unwrap();
                assert_ne!(value, spec.default_value(), "{}: {}", info.id, spec.name);
            }
            let value = spec.default_value();
            assert_eq!(
                spec.parse_text(&value.to_string()).unwrap(),
                value,
                "{}: {} has an invalid default",
                info.id,
                spec.name
            );
        }
        assert!(method.plan(&setup(info.id, "").params).is_ok());
    }
}

/// The facts that tables, charts, the window and the tests take from the registry, their only source.
#[test]
fn every_fact_that_others_need_is_there() {
    for method in REGISTRY {
        let info = method.info();
        let (id, trials) = (info.id, &info.trials);
        let sentence = |text: &str| text.len() > 20 && text.ends_with('.') && !text.contains('|');
        assert!(sentence(info.expect), "{id}: what fails? {}", info.expect);
        assert!(
            !info.summary.is_empty() && !info.summary.contains('|'),
            "{id}"
        );
        assert!(
            !info.summary.ends_with('.') && info.colour <= 0xff_ff_ff,
            "{id}"
        );
        assert_eq!(info.texel == "–", !has_map(id), "{id}: {}", info.texel);
        assert_eq!(trials.texels.is_empty(), !has_map(id), "{id}: texels");
        let bare = info.specs().next().is_none();
        assert!(bare || !trials.pictures.is_empty(), "{id}: pictures");
        assert!(bare || !trials.clouds.is_empty(), "{id}: clouds");
        let shadowed = info.role != Role::Unshadowed;
        assert_eq!(shadowed, !trials.exact.is_empty(), "{id}: exact settings");
        for setting in exact_settings(info, 1.0) {
            named_values(&setup(id, &setting));
        }
        for trial in [trials.pictures, trials.clouds, trials.texels].concat() {
            let (right, wrong) = (setup(id, trial.params), setup(id, trial.control));
            assert_ne!(right, wrong, "{id} {}: no control", trial.params);
            named_values(&right);
        }
    }
    let playing = |role| REGISTRY.iter().filter(|m| m.info().role == role).count();
    assert_eq!([Role::Floor, Role::Truth].map(playing), [1, 1]);
}

/// Every value of a texel has a name, and no two have the same.
fn named_values(setup: &MethodSetup) {
    let plan = setup.method.plan(&setup.params).unwrap();
    let names = setup.method.value_names(&setup.params).unwrap();
    assert_eq!(
        names.len(),
        plan.map_values().unwrap_or(0) as usize,
        "{setup:?}"
    );
    let distinct: HashSet<_> = names.iter().filter(|name| !name.is_empty()).collect();
    assert_eq!(distinct.len(), names.len(), "{setup:?}: {names:?}");
}
