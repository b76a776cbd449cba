//! The guide: which method is best for an error limit, a budget or a value of an axis, as sentences computed from the
//! records, each with the cells it is computed from.

use super::claims::CellLink;
use super::interval::Interval;
use super::select::{self, Found, Records};
use crate::config::{Pick, Question};
use crate::report::format::{bytes, number};
use serde::Serialize;
use serde_json::Map;

/// A sentence and its cells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sentence {
    /// The sentence.
    pub text: String,
    /// Cells that the sentence is computed from; empty where it says that no cell fits.
    pub cells: Vec<CellLink>,
}

/// The answer to a question.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Heading.
    pub title: String,
    /// Explanation of what is compared.
    pub words: String,
    /// Sentences in order.
    pub sentences: Vec<Sentence>,
}

/// Answers a question; a question that cannot be answered gets a sentence with the reason.
pub fn answer(records: &Records<'_>, question: &Question) -> Answer {
    let (title, words, sentences) = match question {
        Question::Along {
            title,
            words,
            metric,
            experiment,
            along,
            along_words,
            series,
            at,
        } => {
            let picks = picks(experiment, series, at);
            let axis = (along.as_str(), along_words.as_str());
            (title, words, along_axis(records, metric, &picks, axis))
        }
        Question::Within {
            title,
            words,
            metric,
            experiment,
            series,
            at,
            budget_words,
            budget,
            limits,
        } => {
            let picks = picks(experiment, series, at);
            let budget = budget.as_deref().map(|b| (b, budget_words.as_str()));
            (
                title,
                words,
                within(records, metric, &picks, budget, limits),
            )
        }
    };
    Answer {
        title: title.clone(),
        words: words.clone(),
        sentences: sentences.unwrap_or_else(|reason| {
            vec![Sentence {
                text: format!("No answer here: {reason}."),
                cells: Vec::new(),
            }]
        }),
    }
}

fn picks(experiment: &str, series: &[String], at: &Map<String, serde_json::Value>) -> Vec<Pick> {
    let pick = |name: &String| Pick {
        experiment: experiment.to_owned(),
        series: name.clone(),
        at: at.clone(),
    };
    series.iter().map(pick).collect()
}

/// A setting with its value of the compared number, at one value of the axis or within one limit.
#[derive(Clone)]
struct Competitor<'a> {
    label: &'a str,
    found: Found<'a>,
    value: Interval,
}

/// Settings that no other surely beats (its whole interval is better), best median first, and the best of the others.
struct Podium<'a> {
    leaders: Vec<Competitor<'a>>,
    next: Option<Competitor<'a>>,
}

fn podium<'a>(mut entries: Vec<Competitor<'a>>, metric: &str) -> Result<Podium<'a>, String> {
    entries.sort_by(|a, b| a.value.value.total_cmp(&b.value.value));
    if entries.is_empty() {
        return Err("no cell competes".to_owned());
    }
    let beats = |a: &Competitor<'a>, b: &Competitor<'a>| {
        let ratio = select::ratio(&a.found, &b.found, metric);
        ratio.map_or(a.value.high < b.value.low, |r| r.interval.high < 1.0)
    };
    let beaten = |entry: &Competitor<'a>| entries.iter().any(|other| beats(other, entry));
    let (next, leaders): (Vec<_>, Vec<_>) = entries.iter().cloned().partition(beaten);
    Ok(Podium {
        next: next.into_iter().next(),
        leaders,
    })
}

impl Podium<'_> {
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.leaders.iter().map(|e| e.label).collect();
        names.sort_unstable();
        names
    }

    fn cells(&self) -> Vec<CellLink> {
        let entries = self.leaders.iter().chain(&self.next);
        entries.map(|entry| CellLink::from(&entry.found)).collect()
    }

    /// `srm 12.3, next esm 15.1`, with each number's unit behind it.
    fn text(&self, unit: &str) -> String {
        let shown = |e: &Competitor<'_>| format!("{} {}{unit}", e.label, number(e.value.value));
        let leaders: Vec<String> = self.leaders.iter().map(shown).collect();
        let lead = match leaders.len() {
            1 => leaders[0].clone(),
            _ => leaders.join(", "),
        };
        match &self.next {
            Some(next) => format!("{lead}; next {}", shown(next)),
            None => lead,
        }
    }
}

/// Text of the podium, preceded by `take` where one setting leads alone and by `tied` otherwise.
fn advice(podium: &Podium<'_>, metric: &str, take: &str, tied: &str) -> String {
    let lead = if podium.leaders.len() == 1 {
        take
    } else {
        tied
    };
    format!("{lead} {}", podium.text(unit(metric)))
}

fn unit(metric: &str) -> &'static str {
    if metric.ends_with("_ms") { " ms" } else { "" }
}

/// One sentence for each stretch of the axis with the same leaders.
fn along_axis(
    records: &Records<'_>,
    metric: &str,
    picks: &[Pick],
    (axis, words): (&str, &str),
) -> Result<Vec<Sentence>, String> {
    let mut places: Vec<(f64, Vec<Competitor<'_>>)> = Vec::new();
    for pick in picks {
        for (x, found) in records.along(pick, axis)? {
            let entry = Competitor {
                label: records.label(&pick.series),
                value: select::metric(&found, metric)?.interval,
                found,
            };
            match places.iter_mut().find(|(other, _)| *other == x) {
                Some((_, entries)) => entries.push(entry),
                None => places.push((x, vec![entry])),
            }
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut stretches: Vec<Vec<(f64, Podium<'_>)>> = Vec::new();
    for (x, entries) in places {
        let podium = podium(entries, metric)?;
        match stretches.last_mut() {
            Some(stretch) if stretch[0].1.names() == podium.names() => stretch.push((x, podium)),
            _ => stretches.push(vec![(x, podium)]),
        }
    }
    let sentence = |stretch: &Vec<(f64, Podium<'_>)>| {
        let ends = [&stretch[0], &stretch[stretch.len() - 1]];
        let names = ends[0].1.names();
        let verdict = match names[..] {
            [one] => format!("take {one}"),
            _ => format!("{} are not told apart", names.join(" and ")),
        };
        let (mut text, mut cells) = match stretch.len() {
            1 => (
                format!(
                    "At {words} {}: {verdict} ({}).",
                    place(ends[0].0),
                    ends[0].1.text(unit(metric))
                ),
                Vec::new(),
            ),
            _ => (
                format!(
                    "From {words} {} to {}: {verdict} ({}",
                    place(ends[0].0),
                    place(ends[1].0),
                    ends[0].1.text(unit(metric))
                ),
                ends[1].1.cells(),
            ),
        };
        if stretch.len() > 1 {
            text += &format!(" … {}).", ends[1].1.text(unit(metric)));
        }
        cells.splice(0..0, ends[0].1.cells());
        Sentence { text, cells }
    };
    Ok(stretches.iter().map(sentence).collect())
}

/// Text of an axis value; whole numbers from 10 on have no decimals.
fn place(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() >= 10.0 {
        return format!("{x}");
    }
    number(x)
}

/// One sentence for each limit.
fn within(
    records: &Records<'_>,
    metric: &str,
    picks: &[Pick],
    budget: Option<(&str, &str)>,
    limits: &[f64],
) -> Result<Vec<Sentence>, String> {
    let mut entries = Vec::new();
    for pick in picks {
        let found = records.find(pick)?;
        let value = select::metric(&found, metric)?.interval;
        let value = if value.value < 0.0 {
            Interval::exact(0.0).minus(value)
        } else {
            value
        };
        let label = records.label(&pick.series);
        entries.push(Competitor {
            label,
            found,
            value,
        });
    }
    let Some((name, words)) = budget else {
        let podium = podium(entries, metric)?;
        let text = format!("{}.", advice(&podium, metric, "Take", "Not told apart:"));
        let cells = podium.cells();
        return Ok(vec![Sentence { text, cells }]);
    };
    let mut sentences = Vec::new();
    for limit in limits {
        let mut fitting = Vec::new();
        for entry in &entries {
            if select::metric(&entry.found, name)?.interval.high <= *limit {
                fitting.push(entry.clone());
            }
        }
        let shown = match name.ends_with("_bytes") {
            true => bytes(*limit as u64),
            false => format!("{}{}", number(*limit), unit(name)),
        };
        sentences.push(match podium(fitting, metric) {
            Ok(podium) => Sentence {
                text: format!(
                    "With {words} of at most {shown}: {}.",
                    advice(&podium, metric, "take", "not told apart:")
                ),
                cells: podium.cells(),
            },
            Err(_) => Sentence {
                text: format!("With {words} of at most {shown}: none of these."),
                cells: Vec::new(),
            },
        });
    }
    Ok(sentences)
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{FixtureReport, pick};
    use super::*;
    use serde_json::json;

    fn podium_of(made: &FixtureReport, names: &[&str]) -> (Vec<String>, Option<String>) {
        let records = made.records();
        let entry = |name: &&str| {
            let found = records.find(&pick(name, json!({}))).unwrap();
            Competitor {
                label: found.cell.method.as_str(),
                value: select::metric(&found, "total_ms").unwrap().interval,
                found,
            }
        };
        let podium = podium(names.iter().map(entry).collect(), "total_ms").unwrap();
        let names = podium.names().iter().map(|n| (*n).to_owned()).collect();
        (names, podium.next.map(|e| e.label.to_owned()))
    }

    #[test]
    fn nobody_leads_who_is_beaten_and_a_tie_behind_a_beaten_one_is_not_lost() {
        let mut made = FixtureReport::new(&["a", "b", "c"]);
        // The medians are a < b < c; b is slower than a in every round, c is not.
        made.cell("a", json!({}), &[10.0, 11.0, 12.0, 13.0, 30.0]);
        made.cell("b", json!({}), &[10.5, 11.5, 12.5, 13.5, 31.0]);
        made.cell("c", json!({}), &[20.0, 9.0, 14.0, 10.0, 40.0]);
        let (leaders, next) = podium_of(&made, &["a", "b", "c"]);
        assert_eq!(
            (leaders, next),
            (vec!["a".to_owned(), "c".to_owned()], Some("b".to_owned()))
        );
        let (leaders, next) = podium_of(&made, &["b", "a"]);
        assert_eq!(
            (leaders, next),
            (vec!["a".to_owned()], Some("b".to_owned()))
        );
    }

    #[test]
    fn a_budget_admits_what_it_just_holds() {
        let mut made = FixtureReport::new(&["a", "b"]);
        for (name, bytes, error) in [("a", 100, 0.2), ("b", 101, 0.1)] {
            let cell = made.cell(name, json!({}), &[1.0, 1.0, 1.0]);
            if let Some(result) = &mut cell.result {
                (result.memory.map_bytes, result.error.rel_rmse) = (bytes, error);
            }
        }
        let records = made.records();
        let picks = [pick("a", json!({})), pick("b", json!({}))];
        let limits = [99.0, 100.0, 101.0];
        let budget = Some(("map_bytes", "maps"));
        let said = within(&records, "rel_rmse", &picks, budget, &limits).unwrap();
        let texts: Vec<&str> = said.iter().map(|s| s.text.as_str()).collect();
        assert!(texts[0].ends_with("none of these."), "{}", texts[0]);
        assert!(texts[1].contains("take a 0.2"), "{}", texts[1]);
        assert!(
            texts[2].contains("take b 0.1") && texts[2].contains("next a"),
            "{}",
            texts[2]
        );
    }

    #[test]
    fn a_stretch_of_the_axis_ends_where_the_leaders_change() {
        let mut made = FixtureReport::new(&["a", "b"]);
        for (steps, a, b) in [(1, 5.0, 9.0), (2, 6.0, 9.0), (4, 12.0, 9.0)] {
            made.cell("a", json!({"steps": steps}), &[a, a, a]);
            made.cell("b", json!({"steps": steps}), &[b, b, b]);
        }
        let picks = [pick("a", json!({})), pick("b", json!({}))];
        let said = along_axis(&made.records(), "total_ms", &picks, ("steps", "steps of")).unwrap();
        assert_eq!(said.len(), 2);
        assert!(said[0].text.starts_with("From steps of 1") && said[0].text.contains("take a"));
        assert!(said[1].text.starts_with("At steps of 4") && said[1].text.contains("take b"));
        assert_eq!(said[0].cells.len(), 4);
    }
}
