//! A page of the documentation, as a reader uses it who follows the page: its blocks of commands, and the files that the
//! reader is to save.

use std::fs;
use std::path::{Path, PathBuf};

/// A block between fences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The words beside the opening fence: `sh`, `sh norun`, `toml`.
    pub info: String,
    /// The line of the page on which its text begins, from 1.
    pub line: usize,
    /// The text between the fences.
    pub text: String,
    /// The file that the sentence before it says to save it as.
    pub file: Option<String>,
}

/// A page.
#[derive(Clone, Debug)]
pub struct Page {
    /// The page's path from the root of the repository.
    pub path: PathBuf,
    /// The blocks, in order.
    pub blocks: Vec<Block>,
}

impl Page {
    /// Reads a page of the repository.
    ///
    /// # Panics
    /// When there is no such page, or a fence is never closed.
    #[must_use]
    pub fn read(path: &Path) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let text = fs::read_to_string(root.join(path));
        let text = text.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self { path: path.to_owned(), blocks: blocks(path, &text) }
    }

    /// Every page of the documentation.
    ///
    /// # Panics
    /// When the folder of pages can't be read.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut paths: Vec<PathBuf> =
            ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(PathBuf::from).into();
        for folder in ["docs", "docs/howto"] {
            let entries = fs::read_dir(root.join(folder)).unwrap_or_else(|error| panic!("{folder}: {error}"));
            let names = entries.filter_map(Result::ok).map(|entry| Path::new(folder).join(entry.file_name()));
            paths.extend(names.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
        }
        paths.sort();
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// The commands of the page that are run; where `shown` is set, also those that are only shown.
    pub fn commands(&self, shown: bool) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(move |block| block.info == "sh" || (shown && block.info == "sh norun"))
    }
}

fn blocks(path: &Path, text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    // The paragraph before, on one line.
    let mut before = String::new();
    let mut ended = true;
    for (at, line) in text.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => {
                open = Some(Block {
                    info: info.trim().to_owned(),
                    line: at + 2,
                    text: String::new(),
                    file: saved_as(&std::mem::take(&mut before)),
                });
            }
            (Some(_), Some("")) => blocks.extend(open.take()),
            (Some(block), _) => {
                block.text.push_str(line);
                block.text.push('\n');
            }
            (None, None) if line.is_empty() => ended = true,
            (None, None) => {
                if std::mem::take(&mut ended) {
                    before.clear();
                }
                before.push_str(line);
                before.push(' ');
            }
        }
    }
    assert!(open.is_none(), "{}: a fence is never closed: {open:?}", path.display());
    blocks
}

/// The file name in a sentence such as "Save this as `shelf.toml`" or "Put this into `src/main.rs`".
fn saved_as(sentence: &str) -> Option<String> {
    let after = ["ave this as `", "ut this into `"].iter().find_map(|words| sentence.split_once(words))?.1;
    after.split_once('`').map(|(name, _)| name.to_owned())
}
