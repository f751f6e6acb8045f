//! `rher plot` and `rher stats`: what they draw.

use crate::stats::{run, three_and_one};
use crate::support::{Rher, TINY};
use insta::assert_snapshot;
use std::io::Cursor;

/// Blue of the first line.
pub(crate) const FIRST_INK: [u8; 3] = [0x00, 0x72, 0xb2];

pub(crate) fn read(rher: &Rher, name: &str) -> String {
    std::fs::read_to_string(rher.path(name)).unwrap()
}

/// Width, height and colors.
pub(crate) fn pixels(file: &[u8]) -> (u32, u32, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let samples = info.color_type.samples();
    let colors = bytes.chunks_exact(samples).map(|pixel| [pixel[0], pixel[1], pixel[2]]);
    (info.width, info.height, colors.collect())
}

pub(crate) fn count(pixels: &[[u8; 3]], fits: impl Fn(&[u8; 3]) -> bool) -> usize {
    pixels.iter().filter(|pixel| fits(pixel)).count()
}

#[test]
fn a_plot_has_a_line_for_every_method_a_band_for_several_seeds_and_the_published_curves() {
    let rher = three_and_one();
    rher.ok("plot a1 a2 a3 b1 -o curves.svg");
    let svg = read(&rher, "curves.svg");
    for text in [
        "push: success",
        "rher fast (n = 3)",
        "her fast (n = 1)",
        "rher, published (n = 5)",
        "environment steps",
    ] {
        assert!(svg.contains(&format!(">{text}</text>")), "no `{text}` in:\n{svg}");
    }
    // Three seeds here, and five of the authors' for each method.
    assert_eq!(svg.matches("<polygon").count(), 3, "{svg}");
    // The first sub-task is trained in none of these runs.
    assert!(!svg.contains(">reach<"), "{svg}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(svg.contains("Band: 95 %"), "{svg}");
    // What the pointer shows.
    let hint = "<title>2,500 environment steps\nrher, published: 4.0 % [0.0 %, 8.0 %]\n";
    assert!(svg.contains(hint) && svg.contains("\nher fast: 10.0 %</title>"), "{svg}");

    rher.ok("plot a1 -o one.svg --x time --measure iqm");
    let svg = read(&rher, "one.svg");
    assert_eq!(svg.matches("<polygon").count(), 0, "one run has no band:\n{svg}");
    assert!(svg.contains("wall clock, minutes") && !svg.contains("published"), "{svg}");
}

#[test]
fn a_line_goes_through_what_was_measured() {
    let rher = Rher::new();
    run(&rher, "a", "rher", 1, &[0.0, 0.5, 1.0]);
    rher.ok("plot a --x time -o a.svg");
    let svg = read(&rher, "a.svg");
    let line = svg.lines().find(|line| line.contains("#0072b2")).unwrap();
    let points = line.split("points=\"").nth(1).unwrap().trim_end_matches("\"/>");
    let points: Vec<Vec<f32>> = points
        .split(' ')
        .map(|point| point.split(',').map(|number| number.parse().unwrap()).collect())
        .collect();
    let [[x1, y1], [x2, y2], [x3, y3]] = [0, 1, 2].map(|i| [points[i][0], points[i][1]]);
    assert!((x3 - x2 - (x2 - x1)).abs() < 0.2 && x2 > x1, "evenly to the right: {points:?}");
    assert!((y1 - y2 - (y2 - y3)).abs() < 0.2 && y2 < y1, "evenly up: {points:?}");
}

#[test]
fn sub_tasks_have_panels_of_their_own() {
    let rher = Rher::new();
    rher.ok(&format!("train push {TINY} --env-steps 1000 --out run --quiet"));
    rher.ok("plot run");
    assert!(read(&rher, "curves.svg").contains(">push: reach</text>"));
    rher.ok("plot run --no-subtasks -o success.svg");
    let svg = read(&rher, "success.svg");
    assert!(svg.contains(">push: success</text>") && !svg.contains("reach"), "{svg}");
}

/// Numbers in an attribute of every element with this name.
fn attributes(svg: &str, element: &str, name: &str) -> Vec<f32> {
    let lines = svg.lines().filter(|line| line.starts_with(&format!("<{element} ")));
    let value =
        |line: &str| line.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0.parse().ok();
    lines.filter_map(value).collect()
}

#[test]
fn panels_stand_in_a_grid_below_a_title() {
    let rher = Rher::new();
    let tasks = ["push", "pick", "slide", "reach"];
    for task in tasks {
        run(&rher, task, "rher", 1, &[0.0, 0.5, 1.0]);
        let config =
            read(&rher, &format!("{task}/config.toml")).replace("\"push\"", &format!("{task:?}"));
        rher.write(&format!("{task}/config.toml"), config);
    }
    let columns = |arguments: &str| {
        rher.ok(&format!("plot {} --no-subtasks {arguments}", tasks.join(" ")));
        let svg = read(&rher, "curves.svg");
        let titles: Vec<&str> =
            svg.lines().filter(|line| line.contains(": success</text>")).collect();
        assert_eq!(titles.len(), 4);
        let mut places = attributes(&titles.join("\n"), "text", "x");
        places.sort_by(f32::total_cmp);
        places.dedup();
        (places.len(), svg)
    };
    assert_eq!(columns("").0, 3);
    assert_eq!(columns("--columns 2").0, 2);
    let (one, svg) = columns("--columns 1 --title A<B");
    assert!(one == 1 && svg.contains(">A&lt;B</text>"), "{svg}");
    assert_eq!(rher.run("plot push --columns 0").status, Some(2));
}

#[test]
fn a_line_at_100_percent_is_not_cut_and_a_name_keeps_its_color() {
    let rher = three_and_one();
    run(&rher, "whole", "rher", 9, &[1.0, 1.0]);
    rher.ok("plot whole --x time");
    let svg = read(&rher, "curves.svg");
    let line = svg.lines().find(|line| line.contains("#0072b2")).unwrap();
    let height: f32 =
        line.split_once("points=\"").unwrap().1.split([',', ' ']).nth(1).unwrap().parse().unwrap();
    let titles = attributes(&svg, "text", "y");
    assert!(height > titles[0] + 12.0, "{height} is below the title at {}", titles[0]);

    let ink = |runs: &str, name: &str| {
        rher.ok(&format!("plot {runs} --x time"));
        let svg = read(&rher, "curves.svg");
        let entry = svg.split(&format!(">{name} (n = ")).next().unwrap();
        let color = entry.rsplit_once("stroke=\"").unwrap().1;
        color[..7].to_owned()
    };
    assert_eq!(ink("b1", "her fast"), ink("a1 a2 b1", "her fast"));
    assert_eq!(ink("a1 a2 b1", "rher fast"), "#0072b2");
    assert_ne!(ink("a1 b1", "her fast"), "#0072b2");
}

#[test]
fn statistics_are_drawn_and_printed_as_before() {
    let rher = three_and_one();
    let printed = rher.ok("stats a1 a2 a3 b1 --json");
    assert_eq!(rher.ok("stats a1 a2 a3 b1 --json -o profiles.svg"), printed);
    let svg = read(&rher, "profiles.svg");
    for text in [
        "push: final success",
        "push: reached 95 %",
        "push: higher final success",
        "rher fast over her fast",
        "rher fast (n = 3)",
    ] {
        assert!(svg.contains(&format!(">{text}</text>")), "no `{text}` in:\n{svg}");
    }
    // Two of three runs reached 95 %, the second one at its last evaluation.
    assert!(svg.contains("<title>10,000 environment steps\nrher fast: 66.7 %"), "{svg}");
    assert!(svg.contains("<title>rher fast over her fast: 83.3 %</title>"), "{svg}");
    rher.ok("stats a1 -o profiles.png");
    assert!(pixels(&std::fs::read(rher.path("profiles.png")).unwrap()).0 > 1000);
    assert_eq!(rher.run("stats a1 -o profiles.pdf").status, Some(2));
}

#[test]
fn a_plot_can_be_pixels() {
    let rher = three_and_one();
    rher.ok("plot a1 a2 a3 b1 -o curves.png");
    let (width, height, pixels) = pixels(&std::fs::read(rher.path("curves.png")).unwrap());
    assert!(width > 800 && height > 500, "{width} by {height}");
    assert!(count(&pixels, |pixel| *pixel == FIRST_INK) > 300, "a line");
    assert!(count(&pixels, |pixel| *pixel == [0x22, 0x22, 0x22]) > 100, "letters");
    assert!(count(&pixels, |pixel| *pixel == [0xff; 3]) > pixels.len() / 2, "paper");
}

#[test]
fn what_cannot_be_drawn_or_written_leaves_no_file() {
    let rher = three_and_one();
    rher.write("a2/metrics.jsonl", "");
    for command in ["plot a2 -o out.svg", "report a2 -o out.html"] {
        let ran = rher.run(command);
        assert_eq!(ran.status, Some(5), "{ran}");
    }
    for command in ["plot", "plot a1 -o curves.jpg", "report"] {
        let ran = rher.run(command);
        assert_eq!(ran.status, Some(2), "{ran}");
    }
    assert_snapshot!(rher.run("plot a1 -o nowhere/out.svg"), @"
    exit 6
    error: cannot write `nowhere/out.svg`: No such file or directory (os error 2)

    hint: choose a place where you have write permission
    ");
    std::fs::create_dir(rher.path("out.html")).unwrap();
    assert_eq!(rher.run("report a1 -o out.html").status, Some(6));
    let mut names: Vec<_> =
        std::fs::read_dir(rher.path("")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a1", "a2", "a3", "b1", "out.html"]);
}
