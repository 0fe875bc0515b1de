//! Pieces of a page, as XHTML: text, tables, pictures within the page.

use anyhow::Result;
use slabsplat::Image;
use slabsplat::io;

/// Text as it stands between tags and in attributes.
pub(super) fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}

/// A paragraph of plain text.
pub(super) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// A cell of a table.
pub(super) struct Cell {
    text: String,
    /// Whether another machine, or another run, may say otherwise.
    of_machine: bool,
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), of_machine: false }
    }
}

impl Cell {
    /// What another run may say otherwise.
    pub(super) fn of_machine(text: String) -> Self {
        Self { text, of_machine: true }
    }

    /// The cell within its row.
    pub(super) fn html(&self) -> String {
        let class = if self.of_machine { " class=\"of-machine\"" } else { "" };
        format!("<td{class}>{}</td>", escaped(&self.text))
    }
}

/// A table with a line above it that says what it is; the first column is words, the others numbers.
pub(super) fn table(caption: &str, head: &[&str], rows: Vec<Vec<Cell>>) -> String {
    let mut html = format!(
        "<div class=\"wide\"><table>\n<caption>{}</caption>\n<thead><tr>",
        escaped(caption)
    );
    for cell in head {
        html += &format!("<th scope=\"col\">{}</th>", escaped(cell));
    }
    html += "</tr></thead>\n<tbody>\n";
    for row in rows {
        let cells = row.iter().map(Cell::html);
        html += &format!("<tr>{}</tr>\n", cells.collect::<String>());
    }
    html + "</tbody></table></div>\n"
}

/// A picture, and the words below it.
pub(super) struct Picture {
    pub(super) image: Image,
    pub(super) words: String,
}

/// Pictures side by side, as many as fit into the width, below a line that says what they are.
pub(super) fn pictures(caption: &str, pictures: &[Picture]) -> Result<String> {
    let mut html = String::from("<figure>\n<div class=\"pictures\">\n");
    for Picture { image, words } in pictures {
        let words = escaped(words);
        html += &format!(
            "<div><img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{words}\"/>\
             <p>{words}</p></div>\n",
            base64(&io::png_bytes(image)?),
            image.width(),
            image.height(),
        );
    }
    Ok(html + &format!("</div>\n<figcaption>{}</figcaption>\n</figure>\n", escaped(caption)))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |idx: usize| u32::from(three.get(idx).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for idx in 0..4 {
            let digit = (bits >> (18 - 6 * idx)) & 63;
            text.push(if idx <= three.len() { DIGITS[digit as usize].into() } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4648, section 10.
    #[test]
    fn base64_test_vectors() {
        for (text, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(text.as_bytes()), expected);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xbe]), "/+++");
    }

    #[test]
    fn html_is_escaped() {
        assert_eq!(paragraph("a < b & \"c\""), "<p>a &lt; b &amp; &quot;c&quot;</p>\n");
        let html =
            table("x > y", &["a"], vec![vec!["<b>".into()], vec![Cell::of_machine("1".into())]]);
        assert!(html.contains("<caption>x &gt; y</caption>"), "{html}");
        assert!(html.contains("<td>&lt;b&gt;</td>"), "{html}");
        assert!(html.contains("<td class=\"of-machine\">1</td>"), "{html}");
    }
}
