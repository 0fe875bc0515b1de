//! `slabsplat popping`.

use crate::{answer, json};
use serde_json::json as value;

/// The cube's level turn through 45 degrees, where the grid's slices change their axis.
const TURN: &str = "--eye 0,0,100 --target 0,0,0 --up 0,1,0 --view-height 34 --width 48 --height 48 \
                    --from 42 --to 48 --step 1";

#[test]
fn popping_json_shows_the_pop() {
    let dir = tempfile::tempdir().unwrap();
    let report = json(dir.path(), &format!("popping builtin:cube {TURN} --json"));
    assert_eq!(
        report["sweep"],
        value!({ "motion": "turn", "from": 42.0, "to": 48.0, "step": 1.0 })
    );
    let methods = report["methods"].as_array().unwrap();
    let names: Vec<_> = methods.iter().map(|m| m["method"].as_str().unwrap()).collect();
    assert_eq!(names, ["image-aligned", "axis-aligned", "every-sample", "post-classified"]);
    let ratio = |idx: usize| methods[idx]["pop_ratio"].as_f64().unwrap();
    assert!(ratio(0) < 1.5, "image-aligned does not pop: {}", ratio(0));
    assert!(5.0 * ratio(0) < ratio(1), "axis-aligned pops: {} and {}", ratio(0), ratio(1));
    assert_eq!(methods[0]["changes"].as_array().unwrap().len(), 6);
    assert!(methods[1]["median_change"].as_f64() < methods[1]["largest_change"].as_f64());
    let jitter = |idx: usize| methods[idx]["jitter"].as_f64().unwrap();
    assert!(jitter(0) < jitter(1) && jitter(1) < 2.0, "{} and {}", jitter(0), jitter(1));
    let step = |idx: usize| methods[idx]["largest_step"].as_f64().unwrap();
    assert!(0.0 < step(0) && step(0) < step(1), "{} and {}", step(0), step(1));
    let at: Vec<f64> = serde_json::from_value(methods[1]["at"].clone()).unwrap();
    assert!(at == [44.0, 45.0] || at == [45.0, 46.0], "{at:?}");
}

#[test]
fn popping_table_of_one_method() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), &format!("popping builtin:cube {TURN} --method axis-aligned"));
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(text.lines().nth(1).unwrap().starts_with("axis-aligned "), "{text}");
}

/// An empty picture changes by nothing, and a ratio to nothing is none.
#[test]
fn popping_of_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("popping builtin:cube {TURN} --opacity 0:0 --json");
    let report = json(dir.path(), &args);
    let method = &report["methods"][0];
    assert_eq!([&method["pop_ratio"], &method["jitter"]], [&value!(null); 2]);
    assert_eq!(method["largest_step"], value!(0.0));
}

/// Of a cube that grows, by factors.
#[test]
fn popping_of_a_zoom() {
    let dir = tempfile::tempdir().unwrap();
    let args = "popping builtin:cube --method image-aligned --width 48 --height 48 --zooming";
    let report = json(dir.path(), &format!("{args} --from 0.5 --to 1 --step 1.1 --json"));
    assert_eq!(report["sweep"], value!({ "motion": "zoom", "from": 0.5, "to": 1.0, "step": 1.1 }));
    let method = &report["methods"][0];
    let changes: Vec<f64> = serde_json::from_value(method["changes"].clone()).unwrap();
    assert_eq!(changes.len(), 7);
    assert!(changes.iter().all(|change| 0.0 < *change), "it grows: {changes:?}");
    let spike = method["spike"].as_f64().unwrap();
    assert!(spike < 1.2, "nothing pops: {spike}");
    let text = answer(dir.path(), &format!("{args} --from 2 --to 1 --step 0.8"));
    assert!(text.lines().nth(1).unwrap().ends_with(" times"), "{text}");
}
