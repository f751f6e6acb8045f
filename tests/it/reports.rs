//! `rher report`: what the page says, and that a browser shows it.

use crate::figures::{FIRST_INK, count, pixels, read};
use crate::stats::three_and_one;
use crate::support::{Rher, TINY};
use serde_json::Value;
use std::io::Write as _;
use std::process::Command;

#[test]
fn a_report_is_one_page_that_needs_nothing_else() {
    let rher = three_and_one();
    rher.ok(&format!("train reach {TINY} --env-steps 1000 --out <run> --quiet"));
    rher.ok("report a1 a2 a3 b1 <run> -o report.html");
    let page = read(&rher, "report.html");
    assert!(page.contains("<h1>Runs of push, reach</h1>"), "a title");
    assert!(page.contains("<code>rher report a1 a2 a3 b1 '&lt;run&gt;' -o report.html</code>"));
    assert!(page.contains("<dd>5 runs, in 3 groups</dd>") && page.contains(" UTC</dd>"), "facts");
    for link in page.split("href=\"#").skip(1) {
        let id = &link[..link.find('"').unwrap()];
        assert_eq!(page.matches(&format!(" id=\"{id}\"")).count(), 1, "contents lead to {id}");
    }
    assert!(page.contains("src=\"data:image/gif;base64,R0lGOD"), "an episode");
    assert!(page.contains("No run of push her fast has a policy that this program can show."));
    assert!(page.contains("95 % [90 %, 99 %]"), "the tables of `rher stats`");
    assert!(page.contains(">push: higher final success</text>"), "the pictures of `rher stats`");
    assert!(page.contains("&lt;run&gt;") && !page.contains("<run>"), "names are no markup");
    assert!(page.contains("method = &quot;her&quot;"), "settings");
    let program = concat!("<td>rher ", env!("CARGO_PKG_VERSION"));
    assert_eq!(page.matches(program).count(), 2, "the machine of the run, and that of the page");
    assert_eq!(page.matches("<td>not kept</td>").count(), 4, "machines of runs that kept none");
    assert!(!page.contains("<mark>"), "nothing is running");
    for outside in ["http:", "https:", "<script", "<link rel=\"stylesheet\"", "url("] {
        let namespace = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!namespace.contains(outside), "{outside}");
    }
}

#[test]
fn a_report_draws_every_metric_and_lists_what_a_preset_does_not_say() {
    let rher = Rher::new();
    let set = "--set relay.mirror=0.25 --set exploration.window=7";
    rher.ok(&format!("train dpush {TINY} {set} --env-steps 1200 --out run --quiet"));
    rher.ok("report run -o report.html");
    let page = read(&rher, "report.html");
    let metrics = read(&rher, "run/metrics.jsonl");
    let last: Value = serde_json::from_str(metrics.lines().last().unwrap()).unwrap();
    let drawn = page.split("id=\"s3\"").nth(1).unwrap();
    let titles: Vec<&str> = drawn.split("aria-label=\"").skip(1).collect();
    let mut expected = Vec::new();
    for (key, value) in last.as_object().unwrap() {
        match value {
            // Of its own curves, of the horizontal axis, and what is no number.
            _ if ["success", "success_final", "env_steps", "run", "crc32"]
                .contains(&key.as_str()) => {}
            Value::Object(fields) => expected.extend(fields.keys().cloned()),
            Value::Array(_) if key == "moved" => {
                expected.extend(["object 1", "object 2"].map(str::to_owned));
            }
            Value::Array(_) => {
                expected.extend(["reach 1", "push 1", "reach 2", "push 2"].map(str::to_owned));
            }
            _ => expected.push(key.replace('_', " ")),
        }
    }
    assert!(expected.len() > 20, "{expected:?}");
    // As a part of a panel, or as the only line of one, which has the group's name.
    let alone = [
        ("train success", "training episodes that were solved"),
        ("final distance", "final distance to the targets, m"),
        ("guide", "sub-task that guides"),
        ("critic loss", "critic loss"),
        ("actor loss", "actor loss"),
        ("episodes", "training episodes"),
        ("updates", "updates of the critics"),
        ("wall s", "wall clock, s"),
    ];
    for name in expected {
        let title = alone.iter().find(|(key, _)| *key == name).map(|(_, title)| *title);
        let is_title =
            |title: &str| titles.iter().any(|drawn| drawn.starts_with(&format!("{title}\"")));
        let is_part = drawn.contains(&format!("</svg>{name} (n = 1)</span>"));
        assert!(title.map_or(is_part, is_title), "no `{name}` in:\n{drawn}");
    }
    // The pointer shows what was measured.
    let steps = last["env_steps"].as_u64().unwrap();
    assert!(
        drawn.contains(&format!("<title>1,{:03} environment steps\n", steps - 1000)),
        "{drawn}"
    );

    assert!(page.contains("<tr><td>relay.mirror</td><td>0.5</td><td>0.25</td></tr>"), "{page}");
    assert!(page.contains(" --set exploration.window=7 "), "{page}");
    assert!(
        page.contains("<td>env_steps</td>") && page.contains(" --set env_steps=1200 "),
        "the end"
    );
    assert!(!page.contains("<td>relay.exchange</td>"), "as in the preset");

    // What a later version may write is drawn, too.
    let rher = three_and_one();
    let metrics =
        read(&rher, "a1/metrics.jsonl").replace("\"env_steps\"", "\"new_thing\":2.5,\"env_steps\"");
    rher.write("a1/metrics.jsonl", metrics);
    rher.ok("report a1 -o report.html");
    let page = read(&rher, "report.html");
    assert!(
        page.contains(">new_thing</text>") && page.contains("rher fast: 2.5</title>"),
        "{page}"
    );
}

#[test]
fn runs_that_are_still_running_are_marked() {
    let rher = three_and_one();
    let lock = std::fs::File::create(rher.path("a1/.lock")).unwrap();
    lock.lock().unwrap();
    rher.ok("report a1 a2 -o report.html");
    let page = read(&rher, "report.html");
    assert!(page.contains("<mark>1 run is still running and may change</mark>"), "{page}");
    assert_eq!(page.matches("<td><mark>running</mark></td>").count(), 1);
    rher.ok("plot a1 a2 -o curves.svg");
    assert!(read(&rher, "curves.svg").contains("One run is still running."));
    lock.unlock().unwrap();
    rher.ok("plot a1 a2 -o curves.svg");
    assert!(!read(&rher, "curves.svg").contains("running"));
}

#[test]
fn a_browser_shows_a_report_without_an_error_or_a_request() {
    let Some(browser) = browser() else { return };
    let rher = three_and_one();
    rher.ok(&format!("train push {TINY} --env-steps 1000 --out run --quiet"));
    rher.ok("report a1 a2 a3 b1 run -o report.html");
    rher.write("asking.html", "<img src=\"http://outside.invalid/picture.png\">");
    let shot = rher.path("shot.png");
    let log = rher.path("net.json");
    let see = |page: &str, what: &[&str]| {
        let output = Command::new(&browser)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args(["--disable-sync", "--disable-component-update", "--no-proxy-server"])
            .args(["--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"])
            .args(["--enable-logging=stderr", "--hide-scrollbars", "--window-size=1100,3200"])
            .arg(format!("--user-data-dir={}", rher.path("profile").display()))
            .arg(format!("--log-net-log={}", log.display()))
            .args(what)
            .arg(format!("file://{}", rher.path(page).display()))
            .env("HOME", rher.path(""))
            .output()
            .unwrap();
        let [stdout, stderr] =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(output.status.success(), "{stdout}{stderr}");
        (stdout, stderr, requests_of_the_page(&std::fs::read_to_string(&log).unwrap()))
    };
    let (.., asked) = see("asking.html", &["--dump-dom"]);
    assert_eq!(asked, ["http://outside.invalid/picture.png"], "a request would be noticed");

    let (page, stderr, asked) = see("report.html", &["--dump-dom"]);
    assert!(asked.is_empty() && !stderr.contains("CONSOLE"), "{asked:?} {stderr}");
    for text in ["Runs of push", "12,500", "never", "No run of push her fast"] {
        assert!(page.contains(text), "no `{text}` in:\n{page}");
    }
    // As wide as a phone, in a frame that says how wide its page is.
    let narrow = read(&rher, "report.html").replace(
        "</body>",
        "<script>addEventListener('load', () => parent.document.body.append(
            ` is ${document.documentElement.scrollWidth} wide`))</script></body>",
    );
    let narrow = narrow.replace('&', "&amp;").replace('"', "&quot;");
    let frame =
        format!("<body><iframe style=\"width:390px;border:0\" srcdoc=\"{narrow}\"></iframe>");
    rher.write("narrow.html", frame);
    let (page, stderr, asked) = see("narrow.html", &["--dump-dom"]);
    assert!(asked.is_empty() && !stderr.contains("CONSOLE"), "{asked:?} {stderr}");
    let end = &page[page.len().saturating_sub(100)..];
    assert!(end.contains(" is 390 wide"), "it does not scroll sideways: {end}");

    let screenshot = format!("--screenshot={}", shot.display());
    see("report.html", &[&screenshot, "--blink-settings=preferredColorScheme=0"]);
    let (.., dark) = pixels(&std::fs::read(&shot).unwrap());
    assert!(count(&dark, |pixel| *pixel == DARK_PAPER) > dark.len() / 2, "dark mode is dark");
    assert!(count(&dark, |pixel| *pixel == [0xff; 3]) < dark.len() / 50, "so are its charts");

    see("report.html", &[&screenshot]);
    let (width, height, pixels) = pixels(&std::fs::read(&shot).unwrap());
    assert_eq!((width, height), (1100, 3200));
    assert!(count(&pixels, |pixel| *pixel == FIRST_INK) > 300, "curves are shown");
    let is_wood =
        |[r, g, b]: &[u8; 3]| r.abs_diff(199) < 12 && g.abs_diff(178) < 12 && b.abs_diff(147) < 14;
    assert!(count(&pixels, is_wood) > 20_000, "a table is shown, on which things lie");
}

/// Background of a page in dark mode.
const DARK_PAPER: [u8; 3] = [0x16, 0x18, 0x1b];

/// The addresses that a page asked for, in a browser's log of its network.
///
/// Browsers also ask on their own behalf: such a request has no origin as its initiator.
fn requests_of_the_page(log: &str) -> Vec<String> {
    let log: Value = serde_json::from_str(log).unwrap();
    let initiated = |event: &Value| {
        let params = &event["params"];
        let is_of_a_page = params["initiator"].as_str().is_some_and(|it| it != "not an origin");
        let url = params["url"].as_str().filter(|_| is_of_a_page)?;
        let is_inside = ["file:", "data:"].iter().any(|scheme| url.starts_with(scheme));
        (!is_inside).then(|| url.to_owned())
    };
    log["events"].as_array().unwrap().iter().filter_map(initiated).collect()
}

/// A browser without a window, `RHER_TEST_BROWSER` before all others; `None`, and a note on standard
/// error, where there is none.
fn browser() -> Option<String> {
    if let Ok(chosen) = std::env::var("RHER_TEST_BROWSER") {
        return Some(chosen);
    }
    let names = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];
    let runs = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    let browser = names.into_iter().find(runs);
    if browser.is_none() {
        // Past the harness, which keeps what passing tests print.
        let _ = writeln!(std::io::stderr(), "ignored: no browser, expected one of {names:?}");
    }
    browser.map(str::to_owned)
}

#[test]
fn a_report_of_what_ships_names_it_as_it_was_asked_for() {
    let rher = Rher::new();
    rher.ok("report reach -o page.html");
    let page = std::fs::read_to_string(rher.path("page.html")).unwrap();
    assert!(page.contains("the first evaluation episode of reach"));
    assert!(!page.contains(&std::env::temp_dir().join("rher-").display().to_string()));
}

#[test]
fn a_page_takes_what_is_there_and_keeps_what_it_is_written_to() {
    let rher = Rher::new();
    rher.ok(&format!("train reach --quiet --env-steps 500 {TINY} --out runs/a"));
    rher.ok(&format!("sweep reach --seeds 1 --env-steps 300 {TINY} --out runs/swept"));
    let ran = rher.run("report runs/a runs/swept -o page.html");
    assert_eq!(ran.status, Some(0), "{ran}");
    assert!(ran.stderr.contains("`runs/swept` holds no run") && ran.stderr.contains("left out"));
    assert_eq!(rher.run("report runs/swept -o page.html").status, Some(5));

    let link = rher.path("link.html");
    std::os::unix::fs::symlink("page.html", &link).unwrap();
    std::fs::write(rher.path("page.html"), "").unwrap();
    rher.ok("report runs/a -o link.html");
    assert!(link.is_symlink() && std::fs::metadata(rher.path("page.html")).unwrap().len() > 0);
    let pipe =
        "mkfifo pipe; wc -c < pipe > count & \"$RHER\" report runs/a -o pipe; wait; cat count";
    let ran = crate::support::shell(&rher, pipe);
    assert!(ran.stdout.trim().parse::<u64>().unwrap() > 1000, "{ran}");

    std::fs::write(rher.path("runs/a/policy.safetensors"), "damaged").unwrap();
    let ran = rher.run("report runs/a -o page.html");
    assert!(ran.status == Some(0) && ran.stderr.contains("no film of `runs/a`"), "{ran}");
}
