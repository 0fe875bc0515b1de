//! The word by which a viewer shows that it was given the link.

use crate::ServeError;
use std::hint::black_box;

/// A secret of a server's.
pub(crate) struct Token(String);

/// Bytes at random in a token that nobody has chosen.
const RANDOM_BYTES: usize = 16;

/// More characters than anybody needs.
const MAX_LEN: usize = 128;

impl Token {
    /// One that nobody can guess.
    pub(crate) fn random() -> Result<Self, ServeError> {
        let mut bytes = [0; RANDOM_BYTES];
        getrandom::fill(&mut bytes).map_err(|_| ServeError::NoRandomNumbers)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// One that somebody has chosen. It stands in links as it is.
    pub(crate) fn chosen(text: &str) -> Result<Self, ServeError> {
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
        if text.is_empty() || MAX_LEN < text.len() || !text.bytes().all(is_plain) {
            return Err(ServeError::BadToken);
        }
        Ok(Self(text.to_owned()))
    }

    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Whether a query has it, `token=…`.
    pub(crate) fn is_in(&self, query: Option<&str>) -> bool {
        let mut pairs = query.unwrap_or("").split('&');
        pairs.find_map(|pair| pair.strip_prefix("token=")).is_some_and(|text| self.is(text))
    }

    /// It takes as long to find the last wrong character as the first.
    fn is(&self, text: &str) -> bool {
        let differences = self.0.bytes().zip(text.bytes()).map(|(a, b)| a ^ b);
        let is_same = black_box(differences.fold(0, |all, one| black_box(all | one))) == 0;
        is_same & (self.0.len() == text.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn token_is_told_from_others() {
        let [a, b] = [0, 1].map(|_| Token::random().unwrap());
        assert_eq!(a.text().len(), 32);
        assert!(a.is_in(Some(&format!("x=1&token={}", a.text()))));
        assert!(!a.is_in(Some(&format!("token={}", b.text()))), "128 bits are not the same twice");
        let secret = Token::chosen("se-cret").unwrap();
        let queries = ["", "token", "token=", "token=se-cre", "token=se-crets", "token=Se-cret"];
        assert!(queries.into_iter().all(|query| !secret.is_in(Some(query))));
        assert!(!secret.is_in(None) && secret.is_in(Some("token=se-cret")));
        for bad in ["", "a b", "a&b", "ä", &"a".repeat(129)] {
            assert!(matches!(Token::chosen(bad), Err(ServeError::BadToken)), "{bad}");
        }
    }
}
