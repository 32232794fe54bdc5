//! Messages that a person can read, whatever input they quote.

use std::borrow::Cow;

/// The longest line that is said whole, in characters; of a longer one so many are said from its beginning and its end.
const LINE_MAX: usize = 1_200;
const LINE_BEGIN: usize = 800;
const LINE_END: usize = 300;
/// The longest number that is said whole, in digits; of a longer one so many are said.
const DIGITS_MAX: usize = 40;
const DIGITS_BEGIN: usize = 10;

/// A message without what nobody would read: of a very long line the middle is left out, and of a number of hundreds of digits
/// most of them. Errors quote what they were given, and that may be anything.
#[must_use]
pub fn readable(message: &str) -> Cow<'_, str> {
    if message.len() <= DIGITS_MAX {
        return Cow::Borrowed(message);
    }
    let lines: Vec<_> = message.split('\n').map(line).collect();
    if lines.iter().all(|line| matches!(line, Cow::Borrowed(_))) {
        return Cow::Borrowed(message);
    }
    Cow::Owned(lines.join("\n"))
}

fn line(line: &str) -> Cow<'_, str> {
    let mut line = numbers(line);
    let length = line.chars().count();
    if length > LINE_MAX {
        let place = |at| line.char_indices().nth(at).map_or(line.len(), |(place, _)| place);
        let (begin, end) = (place(LINE_BEGIN), place(length - LINE_END));
        let left_out = length - LINE_BEGIN - LINE_END;
        line = Cow::Owned(format!("{} … ({left_out} characters) … {}", &line[..begin], &line[end..]));
    }
    line
}

fn numbers(line: &str) -> Cow<'_, str> {
    let mut text = String::new();
    // Up to where `line` is in `text`.
    let mut done = 0;
    let is_digit = |at: usize| line.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let mut at = 0;
    while at < line.len() {
        let digits = (at..).take_while(|at| is_digit(*at)).count();
        if digits > DIGITS_MAX {
            // Digits are one byte each.
            text.push_str(&line[done..at + DIGITS_BEGIN]);
            text.push_str(&format!("… ({digits} digits)"));
            done = at + digits;
        }
        at += digits.max(1);
    }
    if done == 0 {
        return Cow::Borrowed(line);
    }
    Cow::Owned(text + &line[done..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_read_stays_as_it_is() {
        for message in ["", "no such file", "é 1234567890", &"a word ".repeat(170)] {
            assert!(matches!(readable(message), Cow::Borrowed(same) if same == message));
        }
    }

    #[test]
    fn numbers_of_hundreds_of_digits_are_cut() {
        let message = format!("{:.3} is outside 0..=1; é {}", 1e308, "9".repeat(41));
        let said = readable(&message);
        assert_eq!(said, "1000000000… (309 digits).000 is outside 0..=1; é 9999999999… (41 digits)");
    }

    #[test]
    fn of_a_long_line_the_beginning_and_the_end_are_said() {
        for input in ["é".repeat(10_000), "so many words ".repeat(1_000)] {
            let said = readable(&format!("{input:?} is no name\nuse 1 to 32 of a-z")).into_owned();
            assert!(said.chars().count() < LINE_MAX + 100, "{said}");
            assert!(
                said.ends_with("is no name\nuse 1 to 32 of a-z") && said.contains(" characters) … "),
                "{said}"
            );
        }
    }
}
