//! The site: it builds, no link in it is broken, and every page of `docs` is a chapter.

use crate::python;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The pages that are chapters of the site, by their paths from the root of the repository.
pub(crate) fn chapters() -> Vec<PathBuf> {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let linked = summary.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0);
    let path = |name: &str| match name.strip_prefix("../") {
        Some(outside) => PathBuf::from(outside),
        None => Path::new("docs").join(name),
    };
    linked.map(path).collect()
}

#[test]
fn the_site_builds_and_every_link_in_it_leads_somewhere() {
    let Some(python) = python::python() else { return };
    let site = Path::new(env!("CARGO_TARGET_TMPDIR")).join("site");
    let beside = python.parent().unwrap();
    let path = format!("{}:{}", beside.display(), std::env::var("PATH").unwrap());
    let mut build = Command::new(beside.join("mdbook"));
    build.args(["build", "--dest-dir"]).arg(&site).arg(root()).env("PATH", path);
    let output = build.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("WARN"), "{said}");
    let checked = python::run(python, "links.py", &[&site]);
    let checked: usize = checked.trim().parse().unwrap();
    assert!(checked > 1000, "only {checked} links were checked");
}

#[test]
fn every_page_of_the_documents_is_a_chapter() {
    let chapters = chapters();
    for folder in ["docs", "docs/archive", "docs/cluster"] {
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let page = Path::new(folder).join(entry.unwrap().file_name());
            let is_page = page.extension().is_some_and(|extension| extension == "md");
            let is_chapter = chapters.contains(&page) || page.ends_with("SUMMARY.md");
            assert!(is_chapter || !is_page, "docs/SUMMARY.md must name {}", page.display());
        }
    }
}
