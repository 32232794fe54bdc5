//! The files of the page, part of this program: nothing is fetched from anywhere.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asset {
    /// Its media type.
    pub(super) kind: &'static str,
    /// Its text.
    pub(super) text: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const DRAWING: &str = "image/svg+xml";

const ASSETS: &[(&str, Asset)] = &[
    ("index.html", Asset { kind: HTML, text: include_str!("page/index.html") }),
    ("style.css", Asset { kind: STYLE, text: include_str!("page/style.css") }),
    ("icon.svg", Asset { kind: DRAWING, text: include_str!("page/icon.svg") }),
    ("main.js", Asset { kind: SCRIPT, text: include_str!("page/main.js") }),
    ("dom.js", Asset { kind: SCRIPT, text: include_str!("page/dom.js") }),
    ("ask.js", Asset { kind: SCRIPT, text: include_str!("page/ask.js") }),
    ("picture.js", Asset { kind: SCRIPT, text: include_str!("page/picture.js") }),
    ("trace.js", Asset { kind: SCRIPT, text: include_str!("page/trace.js") }),
    ("decision.js", Asset { kind: SCRIPT, text: include_str!("page/decision.js") }),
    ("schemas.js", Asset { kind: SCRIPT, text: include_str!("page/schemas.js") }),
    ("claims.js", Asset { kind: SCRIPT, text: include_str!("page/claims.js") }),
    ("graph.js", Asset { kind: SCRIPT, text: include_str!("page/graph.js") }),
    ("facts.js", Asset { kind: SCRIPT, text: include_str!("page/facts.js") }),
];

/// The name of the file at a path, if there is one. The empty path is the page itself.
pub(super) fn named(path: &str) -> Option<&'static str> {
    let path = if path.is_empty() { "index.html" } else { path };
    ASSETS.iter().map(|(name, _)| *name).find(|name| *name == path)
}

/// The file of this name.
pub(super) fn asset(name: &str) -> Option<Asset> {
    ASSETS.iter().find(|(known, _)| *known == name).map(|(_, asset)| *asset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        for (name, asset) in ASSETS {
            let links = asset.text.replace("http://www.w3.org/", "");
            assert!(!links.contains("http://") && !links.contains("https://"), "{name} points elsewhere");
            for unsafe_way in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("] {
                assert!(!asset.text.contains(unsafe_way), "{name} has {unsafe_way}: text is set as text");
            }
        }
    }

    #[test]
    fn every_file_that_the_page_asks_for_is_there() {
        for (name, asset) in ASSETS {
            let quoted = asset.text.split('"').filter_map(|text| text.strip_prefix("./"));
            for path in quoted.filter(|path| !["ask", "fields"].contains(path)) {
                assert!(named(path).is_some(), "{name} wants {path}");
            }
        }
    }
}
