//! Decides which requests are answered at all: those of a browser on this machine, sent by this page, to the address that
//! only the person who started it knows.

use std::borrow::Cow;

use hyper::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderValue, ORIGIN};
use hyper::{Method, StatusCode};

use super::token::Token;

/// A place that a request may lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Route {
    /// A file of the page.
    Asset(&'static str),
    /// A question or an order, as JSON.
    Ask,
    /// The next picture.
    Picture,
    /// The fields of the pictures.
    Fields,
}

/// The status and the text with which a request is turned away.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Denial(pub(super) StatusCode, pub(super) Cow<'static, str>);

const NOT_FROM_HERE: Denial = Denial(
    StatusCode::FORBIDDEN,
    Cow::Borrowed("this page is for this machine, at the address that `pschema view` printed"),
);
const NO_TOKEN: Denial =
    Denial(StatusCode::FORBIDDEN, Cow::Borrowed("that is not the whole address that `pschema view` printed"));
const NOTHING: Denial = Denial(StatusCode::NOT_FOUND, Cow::Borrowed("there is nothing at this address"));
const METHOD: Denial = Denial(StatusCode::METHOD_NOT_ALLOWED, Cow::Borrowed("that can't be done here"));
const NO_JSON: Denial =
    Denial(StatusCode::UNSUPPORTED_MEDIA_TYPE, Cow::Borrowed("a question is application/json"));

/// The place that a request leads to.
pub(super) fn way(
    method: &Method,
    path: &str,
    headers: &HeaderMap,
    port: u16,
    token: &Token,
) -> Result<Route, Denial> {
    from_here(headers, port)?;
    let (given, rest) = path.strip_prefix('/').and_then(|path| path.split_once('/')).ok_or(NO_TOKEN)?;
    if !token.is(given) {
        return Err(NO_TOKEN);
    }
    let (way, wanted) = match rest {
        "ask" => (Route::Ask, Method::POST),
        "picture" => (Route::Picture, Method::GET),
        "fields" => (Route::Fields, Method::GET),
        file => (super::assets::named(file).map(Route::Asset).ok_or(NOTHING)?, Method::GET),
    };
    if *method != wanted {
        return Err(METHOD);
    }
    let json = |value: &HeaderValue| value.as_bytes().eq_ignore_ascii_case(b"application/json");
    if way == Route::Ask && !headers.get(CONTENT_TYPE).is_some_and(json) {
        return Err(NO_JSON);
    }
    Ok(way)
}

/// The refusal of a browser that came through a tunnel with another number at its own end.
fn through_a_tunnel(port: u16) -> Denial {
    let why = format!(
        "this page is at port {port}, and answers no browser that says another. Behind `ssh -L`, forward the same number: \
         ssh -L {port}:127.0.0.1:{port} HOST; then open the address that `pschema view` printed. `pschema view --port N` \
         chooses the number"
    );
    Denial(StatusCode::FORBIDDEN, why.into())
}

/// A page from elsewhere that has its name resolved to this machine (DNS rebinding) still says its own name; and a page
/// from elsewhere that asks this one says where it is from.
fn from_here(headers: &HeaderMap, port: u16) -> Result<(), Denial> {
    let mut named = headers.get_all(HOST).iter();
    let (Some(host), None) = (named.next(), named.next()) else { return Err(NOT_FROM_HERE) };
    let (name, at) = host.to_str().ok().and_then(|host| host.rsplit_once(':')).ok_or(NOT_FROM_HERE)?;
    if !["127.0.0.1", "localhost", "[::1]"].contains(&name) {
        return Err(NOT_FROM_HERE);
    }
    if at != port.to_string() {
        return Err(if at.parse::<u16>().is_ok() { through_a_tunnel(port) } else { NOT_FROM_HERE });
    }
    let own = |origin: &HeaderValue| {
        origin.as_bytes().strip_prefix(b"http://").is_some_and(|rest| rest == host.as_bytes())
    };
    let same = |site: &HeaderValue| matches!(site.as_bytes(), b"same-origin" | b"none");
    // Following the link that was printed, or that another program shows, comes from elsewhere and is no question.
    let followed = headers.get("sec-fetch-mode").is_some_and(|mode| mode == "navigate");
    let from_own_page = headers.get_all(ORIGIN).iter().all(own)
        && (followed || headers.get_all("sec-fetch-site").iter().all(same));
    if from_own_page { Ok(()) } else { Err(NOT_FROM_HERE) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, HeaderValue::from_str(value).unwrap());
        }
        headers
    }

    fn asked(method: Method, path: &str, pairs: &[(&'static str, &str)]) -> Result<Route, u16> {
        let token = Token::draw().unwrap();
        let path = path.replace("TOKEN", token.text());
        way(&method, &path, &headers(pairs), 4000, &token).map_err(|refused| refused.0.as_u16())
    }

    const HERE: (&str, &str) = ("host", "127.0.0.1:4000");
    const JSON: (&str, &str) = ("content-type", "application/json");

    #[test]
    fn the_page_and_its_questions_are_let_in() {
        assert_eq!(asked(Method::GET, "/TOKEN/", &[HERE]), Ok(Route::Asset("index.html")));
        for host in ["localhost:4000", "[::1]:4000"] {
            let main = asked(Method::GET, "/TOKEN/main.js", &[("host", host)]);
            assert_eq!(main, Ok(Route::Asset("main.js")), "{host}");
        }
        let own = [HERE, JSON, ("origin", "http://127.0.0.1:4000"), ("sec-fetch-site", "same-origin")];
        assert_eq!(asked(Method::POST, "/TOKEN/ask", &own), Ok(Route::Ask));
        let followed = [HERE, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")];
        assert_eq!(asked(Method::GET, "/TOKEN/", &followed), Ok(Route::Asset("index.html")));
        assert_eq!(asked(Method::GET, "/TOKEN/picture", &[HERE]), Ok(Route::Picture));
    }

    #[test]
    fn without_the_token_there_is_nothing() {
        for path in ["/", "", "*", "/TOKEN", "/TOKEN0/", "//", "/0123/", "/../TOKEN/", "/ask", "/%54OKEN/"] {
            assert_eq!(asked(Method::GET, path, &[HERE]), Err(403), "{path}");
        }
    }

    #[test]
    fn another_name_for_this_machine_is_refused() {
        let others = ["evil.example", "127.0.0.1", "127.0.0.1:4001", "localhost.evil.example:4000", ""];
        let others = others.into_iter().chain([
            "[::1]",
            "::1:4000",
            "[::1]:4001",
            "[::2]:4000",
            "127.0.0.1:4000:4000",
        ]);
        for host in others {
            assert_eq!(asked(Method::GET, "/TOKEN/", &[("host", host)]), Err(403), "{host}");
        }
        let token = Token::draw().unwrap();
        let told = |host| way(&Method::GET, "/", &headers(&[("host", host)]), 4000, &token).unwrap_err().1;
        for host in ["127.0.0.1:8080", "localhost:8080", "[::1]:8080"] {
            assert!(told(host).contains("ssh -L 4000:127.0.0.1:4000"), "{}", told(host));
        }
        assert!(!told("evil.example:8080").contains("4000"), "no page from elsewhere learns the number");
        assert_eq!(asked(Method::GET, "/TOKEN/", &[]), Err(403));
        assert_eq!(asked(Method::GET, "/TOKEN/", &[HERE, HERE]), Err(403));
    }

    #[test]
    fn another_page_is_refused_even_with_the_token() {
        for from in [("origin", "http://evil.example"), ("origin", "null"), ("sec-fetch-site", "cross-site")]
        {
            assert_eq!(asked(Method::POST, "/TOKEN/ask", &[HERE, JSON, from]), Err(403), "{from:?}");
        }
        let other_port = ("origin", "http://127.0.0.1:4001");
        assert_eq!(asked(Method::POST, "/TOKEN/ask", &[HERE, JSON, other_port]), Err(403));
    }

    #[test]
    fn methods_types_and_paths_are_those_of_the_page() {
        assert_eq!(asked(Method::GET, "/TOKEN/ask", &[HERE]), Err(405));
        assert_eq!(asked(Method::POST, "/TOKEN/", &[HERE, JSON]), Err(405));
        assert_eq!(asked(Method::OPTIONS, "/TOKEN/ask", &[HERE]), Err(405));
        assert_eq!(asked(Method::POST, "/TOKEN/ask", &[HERE, ("content-type", "text/plain")]), Err(415));
        assert_eq!(asked(Method::POST, "/TOKEN/ask", &[HERE]), Err(415));
        for path in ["/TOKEN/mod.rs", "/TOKEN/../main.js", "/TOKEN//", "/TOKEN/main.js/", "/TOKEN/%2e%2e/"] {
            assert_eq!(asked(Method::GET, path, &[HERE]), Err(404), "{path}");
        }
    }
}
