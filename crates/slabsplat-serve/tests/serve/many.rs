//! Much at once, and one server after the other.

use crate::client::{Answer, Viewer, block_on, opened, started, turned};
use serde_json::json;
use slabsplat_serve::{ServeConfig, serve};
use std::sync::Arc;

#[test]
fn newest_of_a_thousand_arrives() {
    let server = started(ServeConfig::default());
    let scenes: Vec<String> =
        (0..10).map(|step| turned(0.1 * f64::from(step), [480, 360])).collect();
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        for number in 0..1000 {
            viewer.ask(0, number, "moving", &scenes[number as usize % 10]).await;
        }
        let mut numbers = Vec::new();
        while numbers.last() != Some(&999) {
            let (header, _) = viewer.picture().await;
            numbers.push(header["number"].as_u64().expect("it is a number"));
        }
        assert!(numbers.is_sorted(), "{numbers:?}");
        assert!(numbers.len() < 500, "{} pictures", numbers.len());
    });
}

/// All panes get their last picture, whatever was given up for another.
#[test]
fn all_panes_come_to_rest() {
    let server = started(ServeConfig::default());
    let scene = turned(0.1, [200, 150]);
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        for pane in 0..4 {
            viewer.ask(pane, 1, "rest", &scene).await;
            viewer.ask(3 - pane, 2, "moving", &scene).await;
        }
        for pane in 0..4 {
            viewer.ask(pane, 3, "rest", &scene).await;
        }
        let mut at_rest = [false; 4];
        while at_rest != [true; 4] {
            let (header, _) = viewer.picture().await;
            let pane = header["pane"].as_u64().expect("it is a number") as usize;
            at_rest[pane] |= header["number"] == json!(3);
        }
    });
}

#[test]
fn servers_follow_each_other_on_a_port() {
    let first = started(ServeConfig::default());
    let port = first.address().port();
    block_on(async {
        let mut viewer = Viewer::connect(&first).await;
        viewer.ask(0, 1, "rest", &turned(0.0, [64, 48])).await;
        viewer.picture().await;
        // A frame may be under way.
        viewer.ask(0, 2, "rest", &turned(0.0, [2000, 2000])).await;
        first.stop();
        while !matches!(viewer.answer().await, Answer::Closed(_)) {}
    });
    first.stop();
    first.wait();
    let second = serve(opened(), ServeConfig::default().token("secret").port(port));
    let second = Arc::new(second.expect("the port is free again"));
    block_on(async {
        let mut viewer = Viewer::connect(&second).await;
        viewer.ask(0, 1, "rest", &turned(0.0, [64, 48])).await;
        viewer.picture().await;
    });
    let waiting = std::thread::spawn({
        let second = second.clone();
        move || second.wait()
    });
    second.stop();
    waiting.join().expect("it ends with the server");
}
