//! Tables of the page.

use maud::{Markup, html};

/// A table with its caption. Where it is wider than the page, it scrolls by itself.
pub(super) fn table(caption: &Markup, headings: &Markup, rows: &Markup) -> Markup {
    html! {
        figure.table {
            figcaption { (caption) }
            div.scroll {
                table {
                    thead { tr { (headings) } }
                    tbody { (rows) }
                }
            }
        }
    }
}
