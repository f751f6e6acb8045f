//! A page of HTML in one file: nothing in it needs a network or a script.

use crate::plot::{Dash, Line, Panel, escaped, sample};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use comfy_table::Table;
use std::fmt::{self, Write as _};

const STYLE: &str = include_str!("style.css");

/// The body of a page, and what is in it.
#[derive(Default)]
pub(super) struct Page {
    body: String,
    contents: Vec<Section>,
}

struct Section {
    title: String,
    parts: Vec<String>,
}

impl Section {
    /// Its entry in the list of contents.
    fn links(&self, number: usize) -> String {
        let Self { title, parts } = self;
        let link = |id: String, title: &str| format!("<a href=\"#s{id}\">{}</a>", escaped(title));
        let parts = parts.iter().enumerate();
        let parts: Vec<String> =
            parts.map(|(part, title)| link(format!("{number}-{}", part + 1), title)).collect();
        let colon = if parts.is_empty() { "" } else { ": " };
        let title = link(number.to_string(), title);
        format!("<li>{title}{colon}{}</li>\n", parts.join(" · "))
    }
}

/// How large a chart is drawn, in pixels; a page shows it as wide as there is room.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Size {
    Large,
    Small,
}

impl Size {
    const fn pixels(self) -> [f32; 2] {
        match self {
            Self::Large => [370.0, 240.0],
            Self::Small => [340.0, 205.0],
        }
    }
}

impl Page {
    fn add(&mut self, markup: fmt::Arguments<'_>) {
        // A string takes whatever is written.
        let _ = self.body.write_fmt(markup);
    }

    /// Begins a section, which the list of contents names.
    pub(super) fn section(&mut self, title: &str) {
        let number = self.contents.len();
        self.add(format_args!("<h2 id=\"s{number}\">{}</h2>\n", escaped(title)));
        self.contents.push(Section { title: title.to_owned(), parts: Vec::new() });
    }

    /// Begins a part of a section.
    pub(super) fn part(&mut self, title: &str) {
        let id = self.contents.last_mut().map_or_else(String::new, |section| {
            section.parts.push(title.to_owned());
            section.parts.len().to_string()
        });
        let section = self.contents.len().saturating_sub(1);
        self.add(format_args!("<h3 id=\"s{section}-{id}\">{}</h3>\n", escaped(title)));
    }

    pub(super) fn paragraph(&mut self, text: &str) {
        self.add(format_args!("<p>{}</p>\n", escaped(text)));
    }

    pub(super) fn code(&mut self, text: &str) {
        self.add(format_args!("<pre>{}</pre>\n", escaped(text)));
    }

    /// A table that scrolls by itself where it is wider than the page.
    pub(super) fn table(&mut self, title: &str, table: &Table) {
        let row = |row: &comfy_table::Row, name: &str| {
            let cell = |cell: &comfy_table::Cell| {
                let text = cell.content();
                let text = escaped(text.trim());
                let text = if text == RUNNING { format!("<mark>{text}</mark>") } else { text };
                format!("<{name}>{text}</{name}>")
            };
            format!("<tr>{}</tr>\n", row.cell_iter().map(cell).collect::<String>())
        };
        let head = table.header().map_or_else(String::new, |header| row(header, "th"));
        let body: String = table.row_iter().map(|line| row(line, "td")).collect();
        let caption = escaped(title);
        self.add(format_args!(
            "<div class=\"scroll\" tabindex=\"0\"><table><caption>{caption}</caption>\n{head}{body}</table></div>\n"
        ));
    }

    /// Charts, as many beside each other as there is room for.
    pub(super) fn charts(&mut self, panels: &[Panel], size: Size) {
        let class = if size == Size::Large { "figures large" } else { "figures" };
        self.add(format_args!("<div class=\"{class}\">\n"));
        for panel in panels {
            let svg = panel.drawing(size.pixels()).svg(panel.title());
            let lines = panel.lines();
            let legend: String = if lines.len() > 1 || size == Size::Large {
                let entry = |Line { look, runs, .. }: &Line| {
                    let name = escaped(&look.name);
                    format!("<span>{}{name} (n = {runs})</span> ", sample(look))
                };
                // Published ones last, as in pictures.
                let (published, ours): (Vec<_>, Vec<_>) =
                    lines.iter().partition(|line| line.look.dash == Dash::Short);
                ours.into_iter().chain(published).map(entry).collect()
            } else {
                String::new()
            };
            self.add(format_args!("<figure>{svg}<figcaption>{legend}</figcaption></figure>\n"));
        }
        self.add(format_args!("</div>\n"));
    }

    /// Pictures with their captions: of each the kind of its file and the file.
    pub(super) fn pictures(&mut self, pictures: &[(String, &str, Vec<u8>)]) {
        self.add(format_args!("<div class=\"figures\">\n"));
        for (caption, kind, file) in pictures {
            let (data, caption) = (STANDARD.encode(file), escaped(caption));
            self.add(format_args!(
                "<figure><img alt=\"{caption}\" src=\"data:{kind};base64,{data}\">\
                 <figcaption>{caption}</figcaption></figure>\n"
            ));
        }
        self.add(format_args!("</div>\n"));
    }

    /// Text that is there when it is asked for.
    pub(super) fn details(&mut self, title: &str, text: &str) {
        let (title, text) = (escaped(title), escaped(text));
        self.add(format_args!("<details><summary>{title}</summary><pre>{text}</pre></details>\n"));
    }

    /// The whole file: title, facts and contents first. Its icon is empty, so that no browser asks
    /// for one.
    pub(super) fn finish(self, title: &str, facts: &[(&str, Fact)]) -> String {
        let Self { body, contents } = self;
        let title = escaped(title);
        let fact = |(name, fact): &(&str, Fact)| {
            format!("<dt>{}</dt><dd>{}</dd>\n", escaped(name), fact.markup())
        };
        let facts: String = facts.iter().map(fact).collect();
        let links = contents.iter().enumerate().map(|(number, section)| section.links(number));
        let contents: String = links.collect();
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>rher: {title}</title>\n<link rel=\"icon\" href=\"data:,\">\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<dl>\n{facts}</dl>\n\
             <nav aria-label=\"Contents\"><ul>\n{contents}</ul></nav>\n{body}</body>\n</html>\n"
        )
    }
}

/// What a table says of a run that is not at its end.
pub(super) const RUNNING: &str = "running";

/// Something about the page as a whole.
pub(super) enum Fact {
    Text(String),
    Code(String),
    /// It may change.
    Now(String),
}

impl Fact {
    fn markup(&self) -> String {
        match self {
            Self::Text(text) => escaped(text),
            Self::Code(text) => format!("<code>{}</code>", escaped(text)),
            Self::Now(text) => format!("<mark>{}</mark>", escaped(text)),
        }
    }
}
