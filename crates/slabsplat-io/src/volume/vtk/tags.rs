//! The tags of an XML file, one by one, without what is between them, which may be gigabytes.
//!
//! Elements and attributes are all that VTK writes. A document type, which can define entities that stand for
//! others without end, is refused; references in attributes are the five of XML and no others.

use std::io::{self, BufRead};

/// A tag, with where what follows it begins.
#[derive(Debug, PartialEq)]
pub(super) struct Tag {
    pub(super) name: String,
    pub(super) attributes: Vec<(String, String)>,
    /// Bytes of the file up to here.
    pub(super) end: u64,
    /// Whether there are but blanks between the tag before and this one.
    pub(super) follows_blanks: bool,
}

/// A reader of tags.
pub(super) struct Tags<R> {
    reader: R,
    /// Bytes read so far.
    at: u64,
}

/// No tag that VTK writes is longer.
const MAX_TAG_BYTES: usize = 1 << 16;

impl Tag {
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }
}

impl<R: BufRead> Tags<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, at: 0 }
    }

    /// The next tag that opens an element, or with `/` that closes one; `None` at the end of the file.
    pub(super) fn next(&mut self) -> io::Result<Result<Option<Tag>, String>> {
        loop {
            let Some(follows_blanks) = self.pass_over_text()? else { return Ok(Ok(None)) };
            let Some(text) = self.tag_text()? else {
                return Ok(Err("its XML breaks off, or has a tag without an end".to_owned()));
            };
            if text.starts_with("!--") || text.starts_with('?') {
                continue;
            }
            if text.starts_with('!') {
                return Ok(Err("its XML has a document type, which is not read".to_owned()));
            }
            let tag = tag(&text, self.at, follows_blanks);
            return Ok(tag.map(Some).ok_or_else(|| {
                let shown: String = text.chars().take(60).collect();
                format!("its XML has a broken tag, {shown:?}")
            }));
        }
    }

    /// Passes over the text up to a `<` and over that, and says whether it was blank; `None` at the end.
    fn pass_over_text(&mut self) -> io::Result<Option<bool>> {
        let mut is_blank = true;
        loop {
            let bytes = self.reader.fill_buf()?;
            let n_bytes = bytes.len();
            if n_bytes == 0 {
                return Ok(None);
            }
            let at = bytes.iter().position(|&byte| byte == b'<');
            is_blank = is_blank && bytes[..at.unwrap_or(n_bytes)].trim_ascii().is_empty();
            let n_used = at.map_or(n_bytes, |at| at + 1);
            self.reader.consume(n_used);
            self.at += n_used as u64;
            if at.is_some() {
                return Ok(Some(is_blank));
            }
        }
    }

    /// The text up to a `>` outside of quotes, which is passed over.
    fn tag_text(&mut self) -> io::Result<Option<String>> {
        let mut text = Vec::new();
        let mut quote = None;
        loop {
            let Some(&byte) = self.reader.fill_buf()?.first() else { return Ok(None) };
            self.reader.consume(1);
            self.at += 1;
            let is_comment = text.starts_with(b"!--");
            match (quote, byte) {
                (None, b'>') if !is_comment || text.ends_with(b"--") => {
                    return Ok(String::from_utf8(text).ok());
                }
                (Some(open), _) if byte == open => quote = None,
                (None, b'"' | b'\'') if !is_comment => quote = Some(byte),
                _ => {}
            }
            text.push(byte);
            // A comment may be of any length, and is not kept.
            if is_comment && 8 < text.len() {
                text.drain(3..text.len() - 2);
            }
            if MAX_TAG_BYTES < text.len() {
                return Ok(None);
            }
        }
    }
}

fn tag(text: &str, end: u64, follows_blanks: bool) -> Option<Tag> {
    let is_closing = text.starts_with('/');
    let text = text.trim_end_matches('/').trim();
    let n_name = text.find(char::is_whitespace).unwrap_or(text.len());
    let (name, mut rest) = text.split_at(n_name);
    let mut attributes = Vec::new();
    loop {
        rest = rest.trim_start();
        if rest.is_empty() {
            break;
        }
        let (key, after) = rest.split_once('=')?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| ['"', '\''].contains(c))?;
        let (value, after) = after[1..].split_once(quote)?;
        attributes.push((key.trim().to_owned(), with_references(value)));
        rest = after;
    }
    let is_name = !name.is_empty() && (is_closing || !name.starts_with('/'));
    is_name.then(|| Tag { name: name.to_owned(), attributes, end, follows_blanks })
}

fn with_references(text: &str) -> String {
    let plain = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    plain.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(text: &str) -> Result<Vec<Tag>, String> {
        let mut tags = Tags::new(text.as_bytes());
        let mut all = Vec::new();
        while let Some(tag) = tags.next().unwrap()? {
            all.push(tag);
        }
        Ok(all)
    }

    #[test]
    fn tags_with_attributes_and_places() {
        let text = "<?xml version=\"1.0\"?>\n<!-- a > \"comment -->\n<A b=\"1 2\"  c = 'x > &lt;&amp;lt;y'>\n\
                    text</A><B/>";
        let all = tags(text).unwrap();
        let names: Vec<&str> = all.iter().map(|tag| tag.name.as_str()).collect();
        assert_eq!(names, ["A", "/A", "B"]);
        assert_eq!(all[0].get("b"), Some("1 2"));
        assert_eq!(all[0].get("c"), Some("x > <&lt;y"));
        assert!(text[all[0].end as usize..].starts_with("\ntext</A>"));
        assert_eq!(
            all.iter().map(|tag| tag.follows_blanks).collect::<Vec<_>>(),
            [true, false, true]
        );
    }

    #[test]
    fn tags_that_are_none() {
        for (text, expected) in [
            ("<A b=\"1", "breaks off"),
            ("<A b>", "broken tag"),
            ("<A b=1>", "broken tag"),
            ("<>", "broken tag"),
            ("<!DOCTYPE x [<!ENTITY a \"aa\">]>", "document type"),
        ] {
            let error = tags(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(tags(&format!("<A b='{}'>", "x".repeat(100_000))).is_err());
        let comment = format!("<!--{}--><A>", "- ->x".repeat(100_000));
        assert_eq!(tags(&comment).unwrap().len(), 1);
        assert_eq!(tags("no tags at all").unwrap(), []);
    }
}
