//! Numbers as V+ reads them.

/// A number as V+ reads it: digits with at most one point, and a sign; no exponents, no `nan`, no `inf`.
pub(crate) fn decimal(text: &str) -> Option<f64> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let some = digits.bytes().any(|byte| byte.is_ascii_digit());
    if text.len() > 24 || !plain || !some || digits.matches('.').count() > 1 {
        return None;
    }
    text.parse().ok()
}
