//! The sum that ends every line of the server program, as `pschema.v2` works it out with `ASC()` and `MOD`.
//!
//! Written anew here, not taken from the driver: an emulator that shared the driver's code would share its slips.

/// Fletcher's sum of the bytes of a line.
#[must_use]
pub(crate) fn sum(bytes: &[u8]) -> u32 {
    let (mut first, mut second) = (0_u32, 0_u32);
    for byte in bytes {
        first = (first + u32::from(*byte)) % 255;
        second = (second + first) % 255;
    }
    second * 256 + first
}

/// A line with its sum.
#[must_use]
pub(crate) fn summed(line: &str) -> String {
    format!("{line} *{}", sum(line.as_bytes()))
}

/// A line without its sum; None when the sum is missing or wrong.
#[must_use]
pub(crate) fn checked(line: &str) -> Option<&str> {
    let (text, given) = line.rsplit_once(" *")?;
    let plain = !given.is_empty() && given.len() <= 5 && given.bytes().all(|byte| byte.is_ascii_digit());
    (plain && given.parse() == Ok(sum(text.as_bytes()))).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_slip_of_one_byte_goes_unnoticed() {
        // Worked out by hand: 80, 80+73=153, 153+78=231, 231+71=302 mod 255 = 47; the second: 80, 233, 464 mod 255 =
        // 209, 256 mod 255 = 1.
        assert_eq!(sum(b"PING"), 256 + 47);
        let line = summed("MOVE 12 1 5 10.000 -45.250 90.000 -80.125");
        assert_eq!(checked(&line), Some("MOVE 12 1 5 10.000 -45.250 90.000 -80.125"));
        for at in 0..line.len() {
            let mut shorter = line.clone();
            shorter.remove(at);
            assert_eq!(checked(&shorter), None, "{shorter}");
            for bit in 0..7 {
                let mut bytes = line.clone().into_bytes();
                bytes[at] ^= 1 << bit;
                let changed = String::from_utf8(bytes).unwrap();
                assert_eq!(checked(&changed), None, "{changed}");
            }
        }
    }
}
