//! The source files of a crate, and which of them name which, read from their tokens.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A path such as `crate::goal::Stage`, segment by segment.
type Segments = Vec<String>;

/// A crate's files under `src`, without its unit tests.
pub(crate) struct Crate {
    /// Every file by the module that it is: `["goal", "stage"]`, and `[]` for the root.
    pub(crate) files: BTreeMap<Segments, File>,
}

/// One source file.
pub(crate) struct File {
    /// Relative to the repository.
    pub(crate) path: String,
    /// Identifiers and literals in the order of the source, unit tests left out.
    pub(crate) words: Vec<String>,
    /// Paths that the code takes names from.
    uses: Vec<Segments>,
    /// Names that are handed on from elsewhere by `pub use`.
    exports: BTreeMap<String, Segments>,
}

impl Crate {
    /// Reads `crates/<name>/src` in the repository at `root`.
    pub(crate) fn read(root: &Path, name: &str) -> Self {
        let src = root.join("crates").join(name).join("src");
        let mut files = BTreeMap::new();
        let mut tests = BTreeSet::new();
        for path in rust_files(&src) {
            let module = module_of(path.strip_prefix(&src).unwrap());
            let tokens = tokens_of(&path);
            let path = path.strip_prefix(root).unwrap().display().to_string();
            let mut file = File { path, words: vec![], uses: vec![], exports: BTreeMap::new() };
            let mut walk = Walk { file: &mut file, tests: vec![] };
            walk.items(&tokens, 0);
            let of_tests = walk.tests;
            tests.extend(of_tests.into_iter().map(|test| [module.clone(), vec![test]].concat()));
            files.insert(module, file);
        }
        files.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
        Self { files }
    }

    /// The files that take names from the other crate `name`.
    pub(crate) fn naming(&self, name: &str) -> Vec<&str> {
        let takes = |(module, file): &(&Segments, &File)| {
            let child = [module.as_slice(), &[name.to_owned()]].concat();
            file.uses.iter().any(|path| path[0] == name) && !self.files.contains_key(&child)
        };
        self.files.iter().filter(takes).map(|(_, file)| file.path.as_str()).collect()
    }

    /// The files that each file takes names from. Names that a module only hands on count as
    /// taken from where they are defined.
    pub(crate) fn imports(&self) -> BTreeMap<&str, BTreeSet<&str>> {
        let of_file = |(module, file): (&Segments, &'_ File)| -> BTreeSet<&str> {
            let used = file.uses.iter().filter_map(|path| self.resolve(module, path, 0));
            let used = used.map(|module| self.files[&module].path.as_str());
            used.filter(|used| *used != file.path).collect()
        };
        self.files.iter().map(|(m, file)| (file.path.as_str(), of_file((m, file)))).collect()
    }

    /// The module whose file defines what `path` names in `module`; `None` in another crate.
    fn resolve(&self, module: &[String], path: &[String], depth: usize) -> Option<Segments> {
        assert!(depth < 16, "{path:?} in {module:?} is exported in a circle");
        let child = |module: &[String], name: &String| {
            let child = [module, std::slice::from_ref(name)].concat();
            self.files.contains_key(&child).then_some(child)
        };
        let mut segments = path.iter().peekable();
        let mut at = match segments.peek()?.as_str() {
            "crate" => vec![],
            "self" | "super" => module.to_vec(),
            _ => child(module, path.first()?).map(|_| module.to_vec())?,
        };
        while let Some(name) = segments.next() {
            match name.as_str() {
                "crate" | "self" => {}
                "super" => {
                    at.pop()?;
                }
                _ => match (child(&at, name), self.files[&at].exports.get(name)) {
                    (Some(child), _) => at = child,
                    (None, Some(elsewhere)) => {
                        let rest = segments.cloned();
                        let path: Segments = elsewhere.iter().cloned().chain(rest).collect();
                        return self.resolve(&at, &path, depth + 1);
                    }
                    (None, None) => return Some(at),
                },
            }
        }
        Some(at)
    }
}

/// Gathers what one file says.
struct Walk<'a> {
    file: &'a mut File,
    /// Modules that exist for unit tests alone.
    tests: Vec<String>,
}

impl Walk<'_> {
    /// Takes in a sequence of tokens, `inline` modules deep in the file.
    fn items(&mut self, tokens: &[TokenTree], inline: usize) {
        let mut rest = tokens;
        while let Some(token) = rest.first() {
            if is_test(rest) {
                let end = rest.iter().position(|token| is_punct(token, ';') || is_braces(token));
                let item = &rest[..end.map_or(rest.len(), |end| end + 1)];
                if let Some(at) = item.iter().position(|token| is_ident(token, "mod")) {
                    self.tests.push(item[at + 1].to_string());
                }
                rest = &rest[item.len()..];
                continue;
            }
            if let Some((exports, length)) = exports(rest) {
                let named = |path: Segments| (path.last().cloned().unwrap_or_default(), path);
                self.file.exports.extend(exports.into_iter().map(named));
                rest = &rest[length..];
                continue;
            }
            if let [TokenTree::Ident(word), TokenTree::Ident(_), TokenTree::Group(body), ..] = rest
                && word == "mod"
            {
                self.items(&trees(body), inline + 1);
                rest = &rest[3..];
                continue;
            }
            let mut paths = vec![];
            let length = path_at(rest, &mut vec![], &mut paths);
            for mut path in paths {
                let up = path.iter().take_while(|name| *name == "super").count().min(inline);
                if up > 0 {
                    path.splice(..up, ["self".to_owned()]);
                }
                self.file.uses.push(path);
            }
            if length > 0 {
                gather(&rest[..length], &mut self.file.words);
                rest = &rest[length..];
                continue;
            }
            match token {
                TokenTree::Group(group) => self.items(&trees(group), inline),
                TokenTree::Ident(_) | TokenTree::Literal(_) | TokenTree::Punct(_) => {
                    gather(&rest[..1], &mut self.file.words);
                }
            }
            rest = &rest[1..];
            // The name of a method or field does not begin a path.
            if is_punct(token, '.')
                && let Some(TokenTree::Ident(name)) = rest.first()
            {
                self.file.words.push(name.to_string());
                rest = &rest[1..];
            }
        }
    }
}

/// Whether an item that only unit tests see begins here.
fn is_test(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(hash), TokenTree::Group(attribute), ..] = tokens else { return false };
    let text = attribute.stream().to_string().replace(' ', "");
    hash.as_char() == '#' && (text == "cfg(test)" || text.starts_with("cfg(all(test,"))
}

/// The paths of a `pub use` that begins here, and how many tokens it has.
fn exports(tokens: &[TokenTree]) -> Option<(Vec<Segments>, usize)> {
    let start = match tokens {
        [public, word, ..] if is_ident(public, "pub") && is_ident(word, "use") => 2,
        [public, TokenTree::Group(_), word, ..]
            if is_ident(public, "pub") && is_ident(word, "use") =>
        {
            3
        }
        _ => return None,
    };
    let length = tokens.iter().position(|token| is_punct(token, ';'))? + 1;
    let mut paths = vec![];
    path_at(&tokens[start..length], &mut vec![], &mut paths);
    Some((paths, length))
}

/// Adds the paths that begin here, those of a use tree one by one; returns how many tokens they
/// have, 0 where there is none. A name alone is a path only inside a tree.
fn path_at(tokens: &[TokenTree], before: &mut Segments, paths: &mut Vec<Segments>) -> usize {
    let depth = before.len();
    let mut at = 0;
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        before.push(name.to_string());
        at += 1;
        let colons = tokens.get(at..at + 2);
        if !colons.is_some_and(|pair| pair.iter().all(|token| is_punct(token, ':'))) {
            break;
        }
        at += 2;
        if let Some(TokenTree::Group(tree)) = tokens.get(at)
            && tree.delimiter() == Delimiter::Brace
        {
            let tokens = trees(tree);
            for branch in tokens.split(|token| is_punct(token, ',')) {
                path_at(branch, before, paths);
            }
            before.truncate(depth);
            return at + 1;
        }
    }
    if at > 1 || depth > 0 && at > 0 {
        paths.push(before.clone());
    }
    before.truncate(depth);
    at
}

/// A circle among these files, if there is one.
pub(crate) fn circle<'a>(imports: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> Option<Vec<&'a str>> {
    fn visit<'a>(
        file: &'a str,
        imports: &BTreeMap<&'a str, BTreeSet<&'a str>>,
        open: &mut Vec<&'a str>,
        done: &mut BTreeSet<&'a str>,
    ) -> Option<Vec<&'a str>> {
        if let Some(start) = open.iter().position(|it| *it == file) {
            return Some(open[start..].to_vec());
        }
        if done.contains(file) {
            return None;
        }
        open.push(file);
        let found = imports.get(file)?.iter().find_map(|next| visit(next, imports, open, done));
        open.pop();
        done.insert(file);
        found
    }
    let mut done = BTreeSet::new();
    imports.keys().find_map(|file| visit(file, imports, &mut vec![], &mut done))
}

/// Every Rust file under `folder`, sorted.
pub(crate) fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The tokens of a file; comments are no tokens.
fn tokens_of(path: &Path) -> Vec<TokenTree> {
    let source = fs::read_to_string(path).unwrap();
    let tokens: TokenStream =
        source.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    tokens.into_iter().collect()
}

/// Every identifier and literal of a file, unit tests included.
pub(crate) fn words_of(path: &Path) -> Vec<String> {
    let mut found = vec![];
    gather(&tokens_of(path), &mut found);
    found
}

/// Adds the identifiers and literals among these tokens.
fn gather(tokens: &[TokenTree], found: &mut Vec<String>) {
    for token in tokens {
        match token {
            TokenTree::Ident(name) => found.push(name.to_string()),
            TokenTree::Literal(text) => found.push(text.to_string()),
            TokenTree::Punct(_) => {}
            TokenTree::Group(group) => {
                gather(&trees(group), found);
            }
        }
    }
}

/// The module that a file is, from its path below `src`. Every crate is a library; a `main.rs` beside
/// it is read like a module that nothing names.
fn module_of(path: &Path) -> Segments {
    let mut module: Segments =
        path.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if module.last().is_some_and(|last| last == "mod") || module == ["lib"] {
        module.pop();
    }
    module
}

/// What a group encloses.
fn trees(group: &Group) -> Vec<TokenTree> {
    group.stream().into_iter().collect()
}

fn is_ident(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == word)
}

fn is_punct(token: &TokenTree, sign: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == sign)
}

fn is_braces(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
}
