//! The page: what it is made of, and how it looks.

use super::html::{self, Cell, escaped};
use std::fmt::Write;

/// What one of the paper's figures or tables has become.
pub(super) struct Section {
    /// Its anchor in the page.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) claims: Vec<Claim>,
    pub(super) body: String,
}

/// What the paper says, beside what came out here.
pub(super) struct Claim {
    pub(super) paper: &'static str,
    pub(super) found: Cell,
    pub(super) agrees: bool,
}

/// Where the page comes from; it is also how a page of ours is known again.
pub(super) const GENERATOR: &str = concat!("slabsplat ", env!("CARGO_PKG_VERSION"), " reproduce");

/// The part of it that is the same in all versions, before and after the version.
const GENERATOR_ENDS: [&str; 2] =
    ["<meta name=\"generator\" content=\"slabsplat ", " reproduce\"/>"];

const STYLE: &str = include_str!("page.css");

/// Whether a page was made here.
pub(super) fn is_ours(page: &str) -> bool {
    let head = page.split("</head>").next().unwrap_or_default();
    let [start, end] = GENERATOR_ENDS;
    head.lines().any(|line| line.starts_with(start) && line.ends_with(end))
}

/// The whole page; `machine` says what drew it.
pub(super) fn page(sections: &[Section], machine: &str) -> String {
    let title = "The paper, reproduced";
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n\
         <meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n\
         <meta name=\"generator\" content=\"{GENERATOR}\"/>\n\
         <title>{title}: slabsplat</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    page += &html::paragraph(
        "Klaus Mueller and Roger Crawfis, “Eliminating Popping Artifacts in Sheet Buffer-Based Splatting”, \
         IEEE Visualization ’98: what it prints, beside what slabsplat computes. The command slabsplat \
         reproduce drew every picture and computed every number on this page, from volumes that are built \
         into the program.",
    );
    // Writing to a string cannot fail.
    let _ =
        writeln!(page, "<p>Drawn by <span class=\"of-machine\">{}</span>.</p>", escaped(machine));
    page += &summary(sections);
    for Section { id, title, body, .. } in sections {
        let _ =
            writeln!(page, "<section id=\"{id}\">\n<h2>{}</h2>\n{body}</section>", escaped(title));
    }
    page + "</body>\n</html>\n"
}

/// All claims, each with the way to its section.
fn summary(sections: &[Section]) -> String {
    let mut html = String::from(
        "<div class=\"wide\"><table class=\"claims\">\n<thead><tr><th scope=\"col\">where</th>\
         <th scope=\"col\">agrees</th><th scope=\"col\">the paper</th><th scope=\"col\">here</th></tr></thead>\n\
         <tbody>\n",
    );
    for Section { id, title, claims, .. } in sections {
        let name = title.split(':').next().unwrap_or(title);
        for Claim { paper, found, agrees } in claims {
            let _ = writeln!(
                html,
                "<tr><td><a href=\"#{id}\">{}</a></td><td>{}</td><td>{}</td>{}</tr>",
                escaped(name),
                if *agrees { "yes" } else { "no" },
                escaped(paper),
                found.html(),
            );
        }
    }
    html + "</tbody></table></div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn page_is_known_again() {
        assert!(is_ours(&page(&[], "a machine")));
        let older = page(&[], "").replace(env!("CARGO_PKG_VERSION"), "0.0.1");
        assert!(is_ours(&older));
        assert!(!is_ours("<html><head>\n<title>slabsplat</title>\n</head></html>"));
        let quoted = format!("<html><head>\n</head><body>\n{}\n</body></html>", page(&[], ""));
        assert!(!is_ours(&quoted), "a page that quotes ours");
        assert!(!is_ours(""));
    }
}
