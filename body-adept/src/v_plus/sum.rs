//! The sum that ends every line to and from the server program, so that no slip of the line becomes another order:
//! Fletcher's sum of the bytes before ` *`, in decimal.

/// The sum of some bytes.
#[must_use]
pub fn sum(bytes: &[u8]) -> u32 {
    let (first, second) = bytes.iter().fold((0, 0), |(first, second), byte| {
        let first = (first + u32::from(*byte)) % 255;
        (first, (second + first) % 255)
    });
    second * 256 + first
}

/// The text with its sum, without a line end.
#[must_use]
pub fn seal(text: &str) -> String {
    format!("{text} *{}", sum(text.as_bytes()))
}

/// The text of a line. None when the line's sum is wrong.
#[must_use]
pub fn unseal(line: &str) -> Option<&str> {
    let (text, given) = line.trim_end_matches(['\r', '\n']).rsplit_once(" *")?;
    // The sum as it would be written, so that two lines with the same meaning are the same bytes.
    (given == sum(text.as_bytes()).to_string()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_one_wrong_or_missing_byte_is_noticed() {
        let line = seal("OK 17 12.500 -80.250 90.000 0.125");
        assert_eq!(unseal(&line), Some("OK 17 12.500 -80.250 90.000 0.125"));
        for index in 0..line.len() {
            let mut without = line.clone();
            without.remove(index);
            assert_eq!(unseal(&without), None, "{without}");
            for wrong in ' '..='~' {
                let mut bytes: Vec<char> = line.chars().collect();
                if bytes[index] != wrong {
                    bytes[index] = wrong;
                    assert_eq!(unseal(&bytes.iter().collect::<String>()), None);
                }
            }
        }
        // Worked out by hand: A = 65; B = 65 + 66 = 131; 65 + 131 = 196.
        assert_eq!(seal("AB"), format!("AB *{}", 196 * 256 + 131));
    }
}
