//! Links and names in the documents.

use super::root;
use super::source::words_of;
use std::fs;
use std::path::{Path, PathBuf};

/// Documents whose named functions and types are looked up in the files that they link to.
const MAPS: [&str; 3] = ["ARCHITECTURE.md", "docs/paper-map.md", "docs/tour.md"];

/// What a definition begins with.
const DEFINE: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "const", "mod"];

/// A link of a Markdown document: what is shown, and where it leads.
struct Link {
    shown: String,
    target: String,
}

/// The links of a document to other files of the repository.
fn links(text: &str) -> Vec<Link> {
    let mut links = vec![];
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        if is_code {
            continue;
        }
        for (at, _) in line.match_indices("](") {
            let Some((target, _)) = line[at + 2..].split_once(')') else { continue };
            let shown = line[..at].rsplit('[').next().unwrap_or_default();
            let target = target.split(['#', ' ']).next().unwrap_or_default();
            if !target.is_empty() && !target.contains("://") {
                links.push(Link { shown: shown.to_owned(), target: target.to_owned() });
            }
        }
    }
    links
}

/// Every Markdown file of the repository.
fn documents(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if !["target", "node_modules", "runs"].contains(&&*name) && !name.starts_with('.') {
                found.extend(documents(&path));
            }
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found
}

#[test]
fn every_link_of_a_document_leads_somewhere() {
    let mut broken = vec![];
    for document in documents(root()) {
        for Link { target, .. } in links(&fs::read_to_string(&document).unwrap()) {
            if !document.parent().unwrap().join(&target).exists() {
                broken.push(format!("{}: {target}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere: {broken:#?}");
}

#[test]
fn functions_and_types_that_the_maps_name_are_in_the_files_that_they_link_to() {
    let mut missing = vec![];
    let mut named = 0;
    for document in MAPS.map(|name| root().join(name)) {
        for Link { shown, target } in links(&fs::read_to_string(&document).unwrap()) {
            let file = document.parent().unwrap().join(&target);
            if file.extension().is_none_or(|extension| extension != "rs") {
                continue;
            }
            let words = words_of(&file);
            for name in shown.split('`').skip(1).step_by(2).filter(|name| !name.contains('/')) {
                named += 1;
                let last = name.rsplit("::").next().unwrap_or(name);
                let defined =
                    words.windows(2).any(|pair| DEFINE.contains(&&*pair[0]) && pair[1] == last);
                if !defined || !name.split("::").all(|part| words.iter().any(|word| word == part)) {
                    missing.push(format!("{}: `{name}` in {target}", document.display()));
                }
            }
        }
    }
    assert!(named > 40, "only {named} names were looked up");
    assert!(missing.is_empty(), "names that are not there: {missing:#?}");
}

#[test]
fn paths_that_the_architecture_names_exist() {
    let mut missing = vec![];
    for line in fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap().lines() {
        for code in line.split('`').skip(1).step_by(2) {
            let is_path = code.starts_with("crates/") || code.starts_with("tests/");
            if is_path && !code.contains('*') && !root().join(code).exists() {
                missing.push(code.to_owned());
            }
        }
    }
    assert!(missing.is_empty(), "paths that do not exist: {missing:#?}");
}
