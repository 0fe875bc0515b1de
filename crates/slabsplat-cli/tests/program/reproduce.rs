//! `slabsplat reproduce`, and the page of it that is in the documentation.

use crate::{answer, diagnostic, names_in};
use roxmltree::{Document, Node, ParsingOptions};

const COMMITTED: &str = include_str!("../../../../docs/reproduce/index.html");

/// The page is made once, since it takes some seconds.
#[test]
fn reproduce_makes_the_page_of_the_documentation() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), "reproduce");
    assert!(text.starts_with("reproduce/index.html: "), "{text}");
    assert_eq!(names_in(&dir.path().join("reproduce")), ["index.html"]);
    let path = dir.path().join("reproduce/index.html");
    let page = std::fs::read_to_string(&path).unwrap();
    check_page(&page);
    check_same_words(&page, COMMITTED);
    assert!(COMMITTED.len() < 1 << 20, "a clone is for ever as large");
    // A page of ours is made anew, and anything else is left alone.
    std::fs::write(&path, "somebody's work").unwrap();
    let error = diagnostic(dir.path(), "reproduce");
    assert!(error.contains("slabsplat reproduce did not make it"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "somebody's work");
}

fn parsed(page: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(page, options).expect("tags are balanced")
}

/// Every figure is there, and nothing is asked of the network.
fn check_page(page: &str) {
    let document = parsed(page);
    let of_tag = |tag: &'static str| {
        document.descendants().filter(move |node| node.tag_name().name() == tag)
    };
    let ids: Vec<_> = of_tag("section").filter_map(|section| section.attribute("id")).collect();
    let expected = ["table-1", "figures-2-and-6", "figure-7", "figure-8", "figure-9", "section-5"];
    assert_eq!(ids, expected);
    assert_eq!(of_tag("script").count(), 0);
    let n_pictures = [("figures-2-and-6", 6), ("figure-7", 3), ("figure-9", 12)];
    for (id, n_pictures) in n_pictures {
        let section = of_tag("section")
            .find(|section| section.attribute("id") == Some(id))
            .expect("it is there");
        let images = section.descendants().filter(|node| node.tag_name().name() == "img");
        assert_eq!(images.count(), n_pictures, "{id}");
    }
    for image in of_tag("img") {
        assert!(
            image
                .attribute("src")
                .unwrap_or_default()
                .starts_with("data:image/png;base64,iVBORw0KGgo")
        );
        assert!(!image.attribute("alt").unwrap_or_default().is_empty());
    }
    for link in of_tag("a").filter_map(|link| link.attribute("href")) {
        assert!(link.strip_prefix('#').is_some_and(|id| ids.contains(&id)), "{link}");
    }
    assert_eq!(of_tag("polyline").count(), 4 + 3 + 3, "lines of plots");
}

/// What no machine changes is the same, numbers to within a unit of their last digit: processors round
/// differently.
fn check_same_words(page: &str, committed: &str) {
    let words = |page: &str| -> Vec<String> {
        let document = parsed(page);
        let is_of_machine = |node: Node<'_, '_>| node.attribute("class") == Some("of-machine");
        let texts = document
            .descendants()
            .filter(|node| node.is_text() && !node.ancestors().any(is_of_machine))
            .filter(|node| !node.ancestors().any(|node| is_claim_of_machine(node)));
        let words = texts.flat_map(|node| node.text().unwrap_or_default().split_whitespace());
        words.map(str::to_owned).collect()
    };
    let (made, committed) = (words(page), words(committed));
    let remedy = "run `cargo run --release -- reproduce docs/reproduce` and look at the page";
    assert_eq!(made.len(), committed.len(), "{remedy}");
    for (made, committed) in made.iter().zip(&committed) {
        assert!(
            made == committed || differ_by_a_digit(made, committed),
            "{made}, {committed}: {remedy}"
        );
    }
}

/// A row of the summary whose answer is a matter of times.
fn is_claim_of_machine(node: Node<'_, '_>) -> bool {
    node.tag_name().name() == "tr"
        && node.ancestors().any(|node| node.attribute("class") == Some("claims"))
        && node.children().any(|cell| cell.attribute("class") == Some("of-machine"))
}

fn differ_by_a_digit(made: &str, committed: &str) -> bool {
    let number = |word: &str| word.trim_end_matches([';', ',', '.', '°']).parse::<f64>().ok();
    let (Some(a), Some(b)) = (number(made), number(committed)) else { return false };
    let n_decimals = |word: &str| word.split_once('.').map_or(0, |(_, digits)| digits.len());
    // A ratio of two small changes has more digits than are certain.
    let is_close = (a - b).abs() < 1e-3 * b.abs();
    is_close || (a - b).abs() < 1.01 * 10_f64.powi(-(n_decimals(made) as i32))
}

#[test]
fn page_numbers_differ_by_a_digit() {
    assert!(differ_by_a_digit("0.934", "0.935") && differ_by_a_digit("1.30", "1.29"));
    assert!(
        !differ_by_a_digit("0.934", "0.936")
            && differ_by_a_digit("305.45", "305.31")
            && !differ_by_a_digit("word", "work")
    );
}
