use super::*;
use serde_json::json;

#[derive(Deserialize)]
struct Holder {
    #[serde(deserialize_with = "deserialize")]
    reconstruct: &'static ReconstructionInfo,
}

#[test]
fn every_entry_says_what_it_is() {
    for (i, info) in infos().enumerate() {
        assert!(infos().take(i).all(|other| other != info), "{}", info.id);
        for text in [info.title, info.brief, info.doc, info.frame] {
            assert!(!text.is_empty(), "{}", info.id);
        }
        assert_eq!(info.citation.is_empty(), info.is_full(), "{}", info.id);
        assert!(info.doc.ends_with('.') && info.frame.ends_with('.'));
        assert!(!info.brief.ends_with('.'), "a clause: {}", info.brief);
    }
    assert_eq!(full(), infos().next().expect("an entry"), "it is the first");
}

#[test]
fn patterns_lie_in_their_blocks_and_what_is_exact_at_rest_marches_every_pixel() {
    for info in infos() {
        let pattern = info.pattern;
        for offset in pattern.offsets {
            assert!(offset[0] < pattern.block[0] && offset[1] < pattern.block[1]);
        }
        assert!(info.rest.frames >= 1 && info.smallest.iter().all(|side| *side >= 1));
        if info.rest.exact {
            assert!(pattern.is_complete(), "{}", info.id);
            assert!(info.rest.frames as usize >= pattern.frames());
        }
        assert_eq!(info.is_full(), pattern == crate::scene::Pattern::EVERY);
    }
}

#[test]
fn names_are_those_of_the_files() {
    for info in infos() {
        assert_eq!(json!(info), json!(info.id));
        let read: Holder = serde_json::from_value(json!({"reconstruct": info.id})).expect("id");
        assert_eq!(read.reconstruct, info);
        assert!(find(info.id).is_ok_and(|found| found.info() == info));
    }
    let read = serde_json::from_value::<Holder>(json!({"reconstruct": "quarter"}));
    let error = read.err().expect("unknown").to_string();
    assert!(error.starts_with("unknown variant `quarter`, expected "));
    assert!(find("quarter").is_err_and(|error| error.to_string().contains("Choose one of: full")));
}
