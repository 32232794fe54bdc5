//! The source of one crate, read as far as its imports go: which file takes which names from which other file.
//!
//! A file is tied to another by a `use` line, or by a path in its code, that leads to something which the other file
//! defines. A path is followed through modules, renames, globs and re-exports to the file of the definition. A re-export
//! by itself ties no file: it hands a name on, and whoever takes the name is tied to the file that defines it. Code under
//! `#[cfg(test)]` is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Ident, Item, UseTree, Visibility};

/// A file takes a name that another file defines.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    /// The file that takes the name.
    pub from: PathBuf,
    /// The file that defines the name.
    pub to: PathBuf,
    /// The name, as it is defined.
    pub name: String,
    /// The first line that leads there, from 1.
    pub line: usize,
}

/// What the source of a crate says about its files.
#[derive(Debug, Default)]
pub struct Imports {
    /// Every file that defines something or takes a name. A file that only declares modules and re-exports is not here.
    pub rooms: BTreeSet<PathBuf>,
    /// Who takes what from whom, one arrow for each name.
    pub arrows: Vec<Arrow>,
    /// The crates of others that each file names.
    pub foreign: BTreeSet<(PathBuf, String)>,
    /// Paths into this crate that could not be followed: the reader, or the source, has to be mended.
    pub lost: Vec<String>,
}

/// Reads the crate whose root is the file `root`. `text` gives the text of a file, or nothing when there is no such file;
/// `foreign` are the names under which the crate can use other crates.
///
/// # Panics
/// When a file that is declared as a module is missing, or is not Rust.
pub fn read(root: &Path, text: &dyn Fn(&Path) -> Option<String>, foreign: &BTreeSet<String>) -> Imports {
    let mut tree = Tree { modules: Vec::new(), text };
    let folder = root.parent().unwrap_or(Path::new("")).to_owned();
    tree.add_file(None, root.to_owned(), folder);
    let mut imports = Imports::default();
    let mut lines = Lines::new();
    for (number, module) in tree.modules.iter().enumerate() {
        if module.defines {
            imports.rooms.insert(module.file.clone());
        }
        for mention in &module.mentions {
            tree.follow(number, mention, foreign, &mut imports, &mut lines);
        }
    }
    let arrow = |((from, to, name), line)| Arrow { from, to, name, line };
    imports.arrows = lines.into_iter().map(arrow).collect();
    imports
}

/// The first line on which a file takes a name from another: by the file that takes it, the file that defines it, and the name.
type Lines = BTreeMap<(PathBuf, PathBuf, String), usize>;

/// One module of the crate. Several modules may stand in one file.
struct Module {
    parent: Option<usize>,
    file: PathBuf,
    /// The folder in which the files of its child modules are.
    folder: PathBuf,
    names: BTreeMap<String, Vec<Meaning>>,
    globs: Vec<Import>,
    mentions: Vec<Mention>,
    /// Whether its file defines anything here, beside modules and re-exports.
    defines: bool,
    /// Words that may name items which macros make here: those outside of any bracket where a macro is used, and those
    /// that follow `enum`, `struct` and the like in the rules of a macro.
    words_of_macros: BTreeSet<String>,
}

/// What a name stands for within a module. One name may stand for a module and a function at once.
#[derive(Clone)]
enum Meaning {
    Module(usize),
    /// Something that is defined in the module itself.
    Definition,
    /// Whatever this path leads to.
    Import(Import),
}

/// The path of an import, or of all the names that a glob imports.
#[derive(Clone)]
struct Import {
    path: Vec<String>,
    /// Whether it hands its names on. The names of a private import can be used in its own module and in those within it.
    is_public: bool,
}

/// A path that the code of a module names.
struct Mention {
    path: Vec<String>,
    line: usize,
    manner: Manner,
}

/// How a path is named.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// By an import, or in code.
    Plain,
    /// By a re-export, which hands the name on and ties no file of this crate.
    Reexport,
    /// In the tokens of a macro or of an attribute, where it may be no path at all.
    Guess,
}

/// The names that were looked up on the way along a path, with the modules in which they were, and whether from inside of
/// them: nothing is looked up twice, so that globs which open each other come to an end.
type Visited = BTreeSet<(usize, Vec<String>, bool)>;

/// Where a path leads.
#[derive(Debug, PartialEq, Eq)]
enum Target {
    /// To definitions of these names in these modules; to none when the path names a module.
    Defined(Vec<(usize, String)>),
    /// To what macros make, if they make it: where nothing else has the name.
    Perhaps(Vec<(usize, String)>),
    /// To a name that no module of this crate has: that of another crate, or one that every module knows, such as `Vec`.
    Elsewhere(String),
    /// The path begins in this crate and breaks off.
    Nowhere,
}

struct Tree<'a> {
    modules: Vec<Module>,
    text: &'a dyn Fn(&Path) -> Option<String>,
}

impl Tree<'_> {
    fn add_file(&mut self, parent: Option<usize>, file: PathBuf, folder: PathBuf) -> usize {
        let text = (self.text)(&file).unwrap_or_else(|| panic!("{}: there is no such file", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| {
            panic!("{}:{}: {error}", file.display(), error.span().start().line);
        });
        self.add_module(parent, file, folder, parsed.items)
    }

    fn add_module(
        &mut self,
        parent: Option<usize>,
        file: PathBuf,
        folder: PathBuf,
        items: Vec<Item>,
    ) -> usize {
        let number = self.modules.len();
        self.modules.push(Module {
            parent,
            file: file.clone(),
            folder: folder.clone(),
            names: BTreeMap::new(),
            globs: Vec::new(),
            mentions: Vec::new(),
            defines: false,
            words_of_macros: BTreeSet::new(),
        });
        let mut reader = Reader { module: &mut self.modules[number], declared: Vec::new(), depth: 0 };
        items.iter().for_each(|item| reader.visit_item(item));
        for declared in reader.declared {
            let child = self.add_child(number, &declared);
            let name = declared.ident.to_string();
            self.modules[number].names.entry(name).or_default().push(Meaning::Module(child));
        }
        number
    }

    fn add_child(&mut self, parent: usize, declared: &syn::ItemMod) -> usize {
        let (name, folder) = (declared.ident.to_string(), self.modules[parent].folder.clone());
        let inside = folder.join(&name);
        if let Some((_, items)) = &declared.content {
            let file = self.modules[parent].file.clone();
            return self.add_module(Some(parent), file, inside, items.clone());
        }
        if let Some(path) = path_attribute(&declared.attrs) {
            let of_parent = self.modules[parent].file.parent().unwrap_or(Path::new("")).to_owned();
            let file = of_parent.join(path);
            let folder = file.parent().unwrap_or(Path::new("")).to_owned();
            return self.add_file(Some(parent), file, folder);
        }
        let (beside, within) = (folder.join(format!("{name}.rs")), inside.join("mod.rs"));
        let file = if (self.text)(&beside).is_some() { beside } else { within };
        self.add_file(Some(parent), file, inside)
    }

    /// Follows one mention and notes where it leads.
    fn follow(
        &self,
        module: usize,
        mention: &Mention,
        foreign: &BTreeSet<String>,
        imports: &mut Imports,
        lines: &mut Lines,
    ) {
        let from = &self.modules[module].file;
        match self.target(module, &mention.path, &mut Visited::new()) {
            Target::Defined(_) | Target::Perhaps(_) if mention.manner == Manner::Reexport => (),
            Target::Defined(definitions) | Target::Perhaps(definitions) => {
                imports.rooms.insert(from.clone());
                for (defining, name) in definitions {
                    let to = &self.modules[defining].file;
                    if to != from {
                        let line = lines.entry((from.clone(), to.clone(), name)).or_insert(mention.line);
                        *line = mention.line.min(*line);
                    }
                }
            }
            Target::Elsewhere(name) if foreign.contains(&name) => {
                imports.foreign.insert((from.clone(), name));
            }
            Target::Elsewhere(_) => (),
            Target::Nowhere if mention.manner == Manner::Guess => (),
            Target::Nowhere => {
                let path = mention.path.join("::");
                imports.lost.push(format!("{}:{}: {path}", from.display(), mention.line));
            }
        }
    }

    /// Where a path leads that stands in `module`.
    fn target(&self, module: usize, path: &[String], visited: &mut Visited) -> Target {
        let Some((first, rest)) = path.split_first() else { return Target::Defined(Vec::new()) };
        match first.as_str() {
            "crate" => self.within(0, rest, module, visited),
            "self" => self.within(module, rest, module, visited),
            "super" => match self.modules[module].parent {
                Some(parent) if rest.first().is_some_and(|next| next == "super") => {
                    self.target(parent, rest, visited)
                }
                Some(parent) => self.within(parent, rest, module, visited),
                None => Target::Nowhere,
            },
            _ => match self.within(module, path, module, visited) {
                Target::Nowhere => Target::Elsewhere(first.clone()),
                target => target,
            },
        }
    }

    /// Where a path leads whose first name is one of `module`, for code that stands in the module `asking`.
    fn within(&self, module: usize, path: &[String], asking: usize, visited: &mut Visited) -> Target {
        let Some((first, rest)) = path.split_first() else { return Target::Defined(Vec::new()) };
        let is_inside = self.is_inside(asking, module);
        if !visited.insert((module, path.to_vec(), is_inside)) {
            return Target::Nowhere;
        }
        let place = &self.modules[module];
        let is_open = |import: &Import| import.is_public || is_inside;
        let meanings = place.names.get(first).map_or(&[][..], Vec::as_slice).iter();
        let meanings: Vec<&Meaning> = meanings
            .filter(|meaning| !matches!(meaning, Meaning::Import(import) if !is_open(import)))
            .collect();
        let (mut reached, mut perhaps) = (Vec::new(), Vec::new());
        let (mut is_known, mut elsewhere) = (false, None);
        // Before another name a name stands for a module where it can: so `digest::digest` comes to an end when
        // `pub use digest::digest` stands beside `mod digest`.
        let is_module = |meaning: &&Meaning| matches!(meaning, Meaning::Module(_));
        let modules_only = !rest.is_empty() && meanings.iter().any(is_module);
        for meaning in meanings.iter().filter(|meaning| !modules_only || is_module(meaning)) {
            let target = match meaning {
                Meaning::Module(child) => self.within(*child, rest, asking, visited),
                Meaning::Definition => Target::Defined(vec![(module, first.clone())]),
                Meaning::Import(import) => self.target(module, &[&import.path, rest].concat(), visited),
            };
            match target {
                Target::Defined(targets) => {
                    is_known = true;
                    reached.extend(targets);
                }
                Target::Perhaps(targets) => perhaps.extend(targets),
                Target::Elsewhere(name) => elsewhere = Some(name),
                Target::Nowhere => (),
            }
        }
        if meanings.is_empty() {
            for glob in place.globs.iter().filter(|glob| is_open(glob)) {
                let Some(opened) = self
                    .module_at(module, &glob.path, &mut Visited::new())
                    .filter(|opened| *opened != module)
                else {
                    continue;
                };
                match self.within(opened, path, module, visited) {
                    Target::Defined(targets) => {
                        is_known = true;
                        reached.extend(targets);
                    }
                    Target::Perhaps(targets) => perhaps.extend(targets),
                    Target::Elsewhere(_) | Target::Nowhere => (),
                }
            }
            if place.words_of_macros.contains(first) {
                perhaps.push((module, first.clone()));
            }
        }
        match elsewhere {
            _ if is_known => Target::Defined(reached),
            _ if !perhaps.is_empty() => Target::Perhaps(perhaps),
            Some(name) => Target::Elsewhere(name),
            None => Target::Nowhere,
        }
    }

    /// Whether a module is another one, or stands within it at any depth.
    fn is_inside(&self, module: usize, outer: usize) -> bool {
        std::iter::successors(Some(module), |module| self.modules[*module].parent)
            .any(|module| module == outer)
    }

    /// The module that a path names, if it names one of this crate.
    fn module_at(&self, module: usize, path: &[String], visited: &mut Visited) -> Option<usize> {
        let Some((first, rest)) = path.split_first() else { return Some(module) };
        if !visited.insert((module, path.to_vec(), true)) {
            return None;
        }
        match first.as_str() {
            "crate" => return self.module_at(0, rest, visited),
            "self" => return self.module_at(module, rest, visited),
            "super" => return self.module_at(self.modules[module].parent?, rest, visited),
            _ => (),
        }
        self.modules[module].names.get(first)?.iter().find_map(|meaning| match meaning {
            Meaning::Module(child) => self.module_at(*child, rest, visited),
            Meaning::Import(import) => self.module_at(module, &[&import.path, rest].concat(), visited),
            Meaning::Definition => None,
        })
    }
}

/// Reads the items of one module into it.
struct Reader<'a> {
    module: &'a mut Module,
    /// The child modules, still to be read.
    declared: Vec<syn::ItemMod>,
    /// How many functions and blocks are around the item that is read.
    depth: usize,
}

impl Reader<'_> {
    fn define(&mut self, name: &Ident) {
        self.module.names.entry(name.to_string()).or_default().push(Meaning::Definition);
    }

    fn mention(&mut self, path: Vec<String>, line: usize, manner: Manner) {
        // `Self::new` and the like lead to where `Self` is named anyhow.
        if path.first().is_some_and(|first| first != "Self") {
            self.module.mentions.push(Mention { path, line, manner });
        }
    }

    /// Reads a `use` tree under the path `before`.
    fn import(&mut self, before: &[String], tree: &UseTree, manner: Manner) {
        let leaf = |last: &Ident| if last == "self" { before.to_vec() } else { joined(before, last) };
        let (line, is_public) = (tree.span().start().line, manner == Manner::Reexport);
        let (name, path) = match tree {
            UseTree::Path(path) => return self.import(&joined(before, &path.ident), &path.tree, manner),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(before, tree, manner));
            }
            UseTree::Glob(_) => {
                self.mention(before.to_vec(), line, manner);
                return self.module.globs.push(Import { path: before.to_vec(), is_public });
            }
            UseTree::Name(name) => (None, leaf(&name.ident)),
            UseTree::Rename(rename) => (Some(rename.rename.to_string()), leaf(&rename.ident)),
        };
        self.mention(path.clone(), line, manner);
        let name = name.or_else(|| path.last().cloned()).unwrap_or_default();
        // A name that is imported as itself, as `use serde;` does, begins outside of this module.
        if path.len() > 1 || path.first() != Some(&name) {
            self.module.names.entry(name).or_default().push(Meaning::Import(Import { path, is_public }));
        }
    }

    /// Finds paths in tokens that the compiler has not read as Rust yet: those of macros and attributes.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let (mut line, mut colons) = (0, 0);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) if path.is_empty() || colons == 2 => {
                    if path.is_empty() {
                        line = ident.span().start().line;
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' && !path.is_empty() && colons < 2 => {
                    colons += 1;
                }
                other => {
                    self.guess(&mut path, line);
                    colons = 0;
                    match other {
                        TokenTree::Ident(ident) => {
                            line = ident.span().start().line;
                            path.push(ident.to_string());
                        }
                        TokenTree::Group(group) => self.tokens(group.stream()),
                        TokenTree::Literal(_) | TokenTree::Punct(_) => (),
                    }
                }
            }
        }
        self.guess(&mut path, line);
    }

    fn guess(&mut self, path: &mut Vec<String>, line: usize) {
        let path = std::mem::take(path);
        if path.len() > 1 {
            self.mention(path, line, Manner::Guess);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if is_for_tests(attributes(item)) {
            return;
        }
        match item {
            Item::Use(item) => {
                let is_private = matches!(item.vis, Visibility::Inherited);
                let manner = if is_private { Manner::Plain } else { Manner::Reexport };
                return self.import(&[], &item.tree, manner);
            }
            Item::Mod(item) => {
                item.attrs.iter().for_each(|attribute| self.visit_attribute(attribute));
                return self.declared.push(item.clone());
            }
            Item::Macro(item) if self.depth == 0 => {
                let tokens = item.mac.tokens.clone();
                let words = if item.ident.is_some() { named_items(tokens) } else { words(tokens) };
                self.module.words_of_macros.extend(words);
            }
            _ => (),
        }
        self.module.defines = true;
        if let Some(name) = name_of(item) {
            self.define(name);
        }
        self.depth += 1;
        visit::visit_item(self, item);
        self.depth -= 1;
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        // A path that begins with two colons begins with the name of another crate.
        if path.leading_colon.is_none() {
            self.mention(names, path.span().start().line, Manner::Plain);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, invoked: &'ast syn::Macro) {
        self.visit_path(&invoked.path);
        self.tokens(invoked.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let syn::Meta::List(list) = &attribute.meta {
            self.tokens(list.tokens.clone());
        }
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {
        // `pub` names no import.
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        let attributes = match item {
            syn::ImplItem::Fn(item) => &item.attrs,
            syn::ImplItem::Const(item) => &item.attrs,
            syn::ImplItem::Type(item) => &item.attrs,
            syn::ImplItem::Macro(item) => &item.attrs,
            _ => return visit::visit_impl_item(self, item),
        };
        if !is_for_tests(attributes) {
            visit::visit_impl_item(self, item);
        }
    }
}

/// The words in tokens, those within brackets left out.
fn words(tokens: TokenStream) -> Vec<String> {
    let word = |token| if let TokenTree::Ident(word) = token { Some(word.to_string()) } else { None };
    tokens.into_iter().filter_map(word).collect()
}

/// The words after `enum`, `struct` and the like in tokens, at any depth.
fn named_items(tokens: TokenStream) -> Vec<String> {
    let (mut named, mut follows) = (Vec::new(), false);
    for token in tokens {
        let makes = matches!(&token, TokenTree::Ident(word) if ITEMS.iter().any(|item| word == item));
        match token {
            TokenTree::Group(group) => named.extend(named_items(group.stream())),
            TokenTree::Ident(word) if follows => named.push(word.to_string()),
            TokenTree::Ident(_) | TokenTree::Literal(_) | TokenTree::Punct(_) => (),
        }
        follows = makes;
    }
    named
}

/// The words that come before the name of an item.
const ITEMS: [&str; 8] = ["const", "enum", "fn", "static", "struct", "trait", "type", "union"];

fn joined(before: &[String], last: &Ident) -> Vec<String> {
    before.iter().cloned().chain([last.to_string()]).collect()
}

/// Whether what bears these attributes is compiled for tests only.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().filter(|attribute| attribute.path().is_ident("cfg")).any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else { return false };
        let words = list.tokens.to_string();
        let mut words = words.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        words.clone().any(|word| word == "test") && !words.any(|word| word == "not" || word == "any")
    })
}

/// The file that `#[path = "…"]` gives to a module.
fn path_attribute(attributes: &[Attribute]) -> Option<String> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("path")).find_map(|attribute| {
        let syn::Meta::NameValue(pair) = &attribute.meta else { return None };
        let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(path), .. }) = &pair.value else { return None };
        Some(path.value())
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn name_of(item: &Item) -> Option<&Ident> {
    match item {
        Item::Const(item) => Some(&item.ident),
        Item::Enum(item) => Some(&item.ident),
        Item::Fn(item) => Some(&item.sig.ident),
        Item::Macro(item) => item.ident.as_ref(),
        Item::Static(item) => Some(&item.ident),
        Item::Struct(item) => Some(&item.ident),
        Item::Trait(item) => Some(&item.ident),
        Item::TraitAlias(item) => Some(&item.ident),
        Item::Type(item) => Some(&item.ident),
        Item::Union(item) => Some(&item.ident),
        _ => None,
    }
}
