//! The secret in the address of the page: 128 random bits.

use crate::failure::Failure;

/// Bytes of a token: 128 bits.
const BYTES: usize = 16;

/// The secret part of the address, which nobody can guess.
pub(super) struct Token {
    text: String,
    /// Compared instead of the text, because `==` of `blake3::Hash` takes the same time whatever it compares.
    hash: blake3::Hash,
}

impl Token {
    /// A new token, drawn by the operating system.
    ///
    /// # Errors
    /// When it has no randomness.
    pub(super) fn draw() -> Result<Self, Failure> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)
            .map_err(|error| Failure::Failed(format!("the system gives no random numbers: {error}")))?;
        Ok(Self::of(bytes))
    }

    fn of(bytes: [u8; BYTES]) -> Self {
        let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Self { hash: blake3::hash(text.as_bytes()), text }
    }

    /// The token as it stands in the address: 32 hexadecimal digits.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Whether the given text is the token, in a time that does not depend on how much of it is right.
    pub(super) fn is(&self, given: &str) -> bool {
        given.len() == self.text.len() && blake3::hash(given.as_bytes()) == self.hash
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_all_of_it_lets_in() {
        let token = Token::of([0xab; BYTES]);
        assert_eq!(token.text(), "ab".repeat(16));
        assert!(token.is(&"ab".repeat(16)));
        for wrong in ["", "ab", &"ab".repeat(15), &"ab".repeat(17), &"AB".repeat(16), &"ac".repeat(16)] {
            assert!(!token.is(wrong), "{wrong}");
        }
        let (one, other) = (Token::draw().unwrap(), Token::draw().unwrap());
        assert_ne!(one.text(), other.text());
    }
}
