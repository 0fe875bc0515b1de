//! The elements of a file, or of an item in it, by their tags, and what their values say.

use super::super::Endian;
use super::tags::Tag;

/// The elements of a file, or of an item in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Dataset {
    elements: Vec<(Tag, Value)>,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Bytes(Vec<u8>, Endian),
    Items(Vec<Dataset>),
}

impl Dataset {
    /// What comes twice is kept once, so that no dataset has more elements than there are tags.
    pub(super) fn add(&mut self, tag: Tag, value: Value) {
        if self.get(tag).is_none() {
            self.elements.push((tag, value));
        }
    }

    fn get(&self, tag: Tag) -> Option<&Value> {
        self.elements.iter().find(|(other, _)| *other == tag).map(|(_, value)| value)
    }

    /// The items of a sequence; none if it is not there.
    pub(super) fn items(&self, tag: Tag) -> &[Self] {
        match self.get(tag) {
            Some(Value::Items(items)) => items,
            _ => &[],
        }
    }

    /// A text, without the blanks that fill it up.
    pub(super) fn text(&self, tag: Tag) -> Option<&str> {
        let Value::Bytes(bytes, _) = self.get(tag)? else { return None };
        let text = str::from_utf8(bytes).ok()?.trim_matches([' ', '\0']);
        (!text.is_empty()).then_some(text)
    }

    /// A number that is written as text.
    pub(super) fn decimal(&self, tag: Tag) -> Option<f64> {
        self.text(tag)?.split('\\').next()?.trim().parse().ok().filter(|n: &f64| n.is_finite())
    }

    /// Numbers that are written as text, all of them finite.
    pub(super) fn decimals<const N: usize>(&self, tag: Tag) -> Option<[f64; N]> {
        let numbers = self.text(tag)?.split('\\').map(|n| n.trim().parse().ok());
        let numbers: Vec<f64> = numbers.collect::<Option<_>>()?;
        let numbers: [f64; N] = numbers.try_into().ok()?;
        numbers.iter().all(|n| n.is_finite()).then_some(numbers)
    }

    /// A whole number that is written as text.
    pub(super) fn whole(&self, tag: Tag) -> Option<i64> {
        self.text(tag)?.split('\\').next()?.trim().parse().ok()
    }

    /// A number of 16 or 32 bits.
    pub(super) fn unsigned(&self, tag: Tag) -> Option<u32> {
        let Value::Bytes(bytes, endian) = self.get(tag)? else { return None };
        let mut number = [0; 4];
        let n_bytes = bytes.len().min(if bytes.len() < 4 { 2 } else { 4 });
        number.get_mut(..n_bytes)?.copy_from_slice(bytes.get(..n_bytes)?);
        if *endian == Endian::Big {
            number[..n_bytes].reverse();
        }
        (n_bytes != 0).then(|| u32::from_le_bytes(number))
    }

    /// A float of 64 bits.
    pub(super) fn double(&self, tag: Tag) -> Option<f64> {
        let Value::Bytes(bytes, endian) = self.get(tag)? else { return None };
        let bytes = bytes.get(..8)?.try_into().ok()?;
        let number = match endian {
            Endian::Little => f64::from_le_bytes(bytes),
            Endian::Big => f64::from_be_bytes(bytes),
        };
        number.is_finite().then_some(number)
    }
}
