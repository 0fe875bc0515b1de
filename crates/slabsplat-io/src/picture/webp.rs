//! WebP: 8 bits a channel, not premultiplied, lossless.
//!
//! What a picture says of itself is in an XMP packet, which is RDF in XML (ISO 16684-1).

use std::io::{self, BufRead, Seek, Write};

use image_webp::{ColorType, EncodingError, WebPDecoder, WebPEncoder};
use roxmltree::Document;
use slabsplat_core::Image;

use super::{Provenance, has_pixels};

/// The names of what is ours.
const NAMESPACE: &str = "https://slabsplat.org/ns/1.0/";

/// XMP's own names, of which `CreatorTool` is one.
const XMP: &str = "http://ns.adobe.com/xap/1.0/";

/// What is read of a picture to find it.
const MAX_BYTES: usize = 8 << 20;

pub(super) fn encode(writer: impl Write, image: &Image, provenance: &Provenance) -> io::Result<()> {
    has_pixels(image)?;
    let mut encoder = WebPEncoder::new(writer);
    if *provenance != Provenance::NONE {
        encoder.set_xmp_metadata(packet(provenance).into_bytes());
    }
    let (width, height) = (image.width(), image.height());
    let encoded = encoder.encode(&image.to_rgba8(), width, height, ColorType::Rgba8);
    encoded.map_err(|error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

pub(super) fn packet(provenance: &Provenance) -> String {
    let element = |name: &str, text: &Option<String>| match text {
        Some(text) => format!("<{name}>{}</{name}>", escaped(text)),
        None => String::new(),
    };
    format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\
         <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" xmlns:xmp=\"{XMP}\" xmlns:slabsplat=\"{NAMESPACE}\">\
         {}{}</rdf:Description></rdf:RDF></x:xmpmeta>",
        element("xmp:CreatorTool", &provenance.program),
        element("slabsplat:scene", &provenance.scene),
    )
}

/// A text in XML, which has no control characters but these.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\r' => escaped.push_str("&#13;"),
            '\n' | '\t' => escaped.push(c),
            _ if c.is_control() => escaped.push(char::REPLACEMENT_CHARACTER),
            _ => escaped.push(c),
        }
    }
    escaped
}

/// What the packet says.
pub(super) fn read_provenance(file: impl BufRead + Seek) -> Result<Provenance, String> {
    let mut decoder = WebPDecoder::new(file).map_err(|error| error.to_string())?;
    decoder.set_memory_limit(MAX_BYTES);
    let packet = decoder.xmp_metadata().map_err(|error| error.to_string())?;
    let Some(packet) = packet.and_then(|bytes| String::from_utf8(bytes).ok()) else {
        return Ok(Provenance::NONE);
    };
    let Ok(document) = Document::parse(&packet) else { return Ok(Provenance::NONE) };
    let text = |namespace: &str, name: &str| {
        let node = document.descendants().find(|node| node.has_tag_name((namespace, name)))?;
        Some(node.text().unwrap_or_default().to_owned())
    };
    Ok(Provenance { program: text(XMP, "CreatorTool"), scene: text(NAMESPACE, "scene") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PictureFormat;
    use std::io::Cursor;

    #[test]
    fn webp_reads_back() {
        let mut image = Image::filled(30, 20, [0.2, 0.4, 0.6, 1.0]);
        image.pixels_mut()[4] = [0.0, 0.0, 0.2, 0.4];
        let scene = "a <b> & \"c\" ]]> ä\r\n\t'".to_owned();
        let provenance = Provenance { program: Some("p".to_owned()), scene: Some(scene) };
        let bytes = PictureFormat::WebP.bytes(&image, Some(&provenance)).unwrap();
        let mut decoder = WebPDecoder::new(Cursor::new(&bytes)).unwrap();
        assert_eq!((decoder.dimensions(), decoder.has_alpha()), ((30, 20), true));
        assert!(!decoder.is_lossy());
        let mut read = vec![0; 4 * 30 * 20];
        decoder.read_image(&mut read).unwrap();
        assert!(read == image.to_rgba8());
        assert_eq!(read_provenance(Cursor::new(&bytes)).unwrap(), provenance);
    }
}
