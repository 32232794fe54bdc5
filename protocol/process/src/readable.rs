//! Messages that a person can read, whatever input they quote.

use std::borrow::Cow;

/// The longest line that is said whole, in characters; of a longer one so many are said from its beginning and its end.
const LINE_MAX: usize = 1_200;
const LINE_BEGIN: usize = 800;
const LINE_END: usize = 300;
/// The same of a word: paths, which are among the longest words that a person means, are shorter.
const WORD_MAX: usize = 300;
const WORD_BEGIN: usize = 80;
const WORD_END: usize = 20;
/// The longest number that is said whole, in digits; of a longer one so many are said.
const DIGITS_MAX: usize = 40;
const DIGITS_BEGIN: usize = 10;

/// Sizes of numbers that a person reads without counting digits.
const READ_AT_SIGHT: std::ops::Range<f64> = 1e-9..1e15;

/// A number as it is, with a power of ten where people would count its digits: `1e300`, and not three hundred zeros.
#[must_use]
pub fn number(value: f64) -> String {
    let at_sight = value == 0.0 || READ_AT_SIGHT.contains(&value.abs());
    if at_sight || !value.is_finite() { value.to_string() } else { format!("{value:e}") }
}

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
    if line.split(' ').any(|word| word.chars().count() > WORD_MAX) {
        let words: Vec<_> = line.split(' ').map(|word| cut(word, WORD_MAX, WORD_BEGIN, WORD_END)).collect();
        line = Cow::Owned(words.join(" "));
    }
    if let Cow::Owned(cut) = cut(&line, LINE_MAX, LINE_BEGIN, LINE_END) {
        return Cow::Owned(cut);
    }
    line
}

/// The text, or if it has more than `max` characters, so many from its beginning and its end.
fn cut(text: &str, max: usize, begin: usize, end: usize) -> Cow<'_, str> {
    let length = text.chars().count();
    if length <= max {
        return Cow::Borrowed(text);
    }
    let place = |at| text.char_indices().nth(at).map_or(text.len(), |(place, _)| place);
    let left_out = length - begin - end;
    Cow::Owned(format!(
        "{}… ({left_out} characters) …{}",
        &text[..place(begin)],
        &text[place(length - end)..]
    ))
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
        for message in ["", "no such file", "é 1234567890", &"a word ".repeat(170), &"word".repeat(75)] {
            assert!(matches!(readable(message), Cow::Borrowed(same) if same == message));
        }
    }

    #[test]
    fn numbers_of_hundreds_of_digits_are_cut() {
        let message = format!("{:.3} is outside 0..=1; é {}", 1e308, "9".repeat(41));
        let said = readable(&message);
        assert_eq!(said, "1000000000… (309 digits).000 is outside 0..=1; é 9999999999… (41 digits)");
    }

    /// Limits of ±1e300 were told with all their zeros.
    #[test]
    fn a_number_is_told_with_a_power_of_ten_where_its_zeros_would_be_counted() {
        for (value, told) in [
            (1e300, "1e300"),
            (-1e300, "-1e300"),
            (2.5e-10, "2.5e-10"),
            (1e15, "1e15"),
            (999_999_999_999_999.0, "999999999999999"),
            (0.1 + 0.2, "0.30000000000000004"),
            (-12.25, "-12.25"),
            (0.0, "0"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), told);
            assert!(value.is_nan() || told.parse() == Ok(value));
        }
    }

    #[test]
    fn of_long_lines_and_words_the_beginning_and_the_end_are_said() {
        let path = format!("/{}", "folder/".repeat(35));
        let message = format!("no stage is named {:?}; see {path}", "y".repeat(10_000));
        let begin = "y".repeat(WORD_BEGIN - 1);
        let end = "y".repeat(WORD_END - 2);
        let expected = format!("no stage is named \"{begin}… (9903 characters) …{end}\"; see {path}");
        assert_eq!(readable(&message), expected);
        for input in ["é".repeat(10_000), "so many words ".repeat(1_000)] {
            let said = readable(&format!("{input:?} is no name\nuse 1 to 32 of a-z")).into_owned();
            assert!(said.chars().count() < LINE_MAX + 100, "{said}");
            assert!(
                said.ends_with("is no name\nuse 1 to 32 of a-z") && said.contains(" characters) …"),
                "{said}"
            );
        }
    }
}
