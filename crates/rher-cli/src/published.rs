//! Runs that are published, as others can be compared with them while they are trained.

/// The runs in `docs/archive/runs/<TASK>-target-seed*`, one on a line: task, success rate in two
/// consecutive evaluations at which it ended, steps from one evaluation to the next, seconds on one
/// core, and for each evaluation the mean success of all sub-tasks in percent.
const RUNS: &str = include_str!("published.txt");

/// Published runs of a task with the preset `fast`, the shortest first.
pub(crate) struct Published {
    /// Success rate in two consecutive evaluations at which they ended.
    pub(crate) until: f32,
    /// At least one.
    pub(crate) runs: Vec<PublishedRun>,
}

/// A published run, until it was solved.
#[derive(Debug, PartialEq)]
pub(crate) struct PublishedRun {
    /// Steps from one evaluation to the next.
    pub(crate) interval: u64,
    /// Seconds on one core.
    pub(crate) wall_s: u64,
    /// Mean success of all sub-tasks in each evaluation, in percent.
    pub(crate) course: Vec<u8>,
}

impl PublishedRun {
    /// Steps after which it was solved.
    pub(crate) fn env_steps(&self) -> u64 {
        self.interval * self.course.len() as u64
    }
}

impl Published {
    /// The runs of a task; `None` if none is published.
    pub(crate) fn of(task: &str) -> Option<Self> {
        let mut published: Option<Self> = None;
        for line in RUNS.lines() {
            let (name, until, run) = read(line).expect("a test reads every line");
            if name == task {
                let so_far = published.get_or_insert(Self { until, runs: Vec::new() });
                so_far.runs.push(run);
            }
        }
        published
    }

    /// Steps after which they were solved, in increasing order.
    pub(crate) fn ends(&self) -> Vec<u64> {
        self.runs.iter().map(PublishedRun::env_steps).collect()
    }
}

fn read(line: &str) -> Option<(&str, f32, PublishedRun)> {
    let mut words = line.split(' ');
    let (name, until) = (words.next()?, words.next()?.parse().ok()?);
    let (interval, wall_s) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    let course = words.map(|rate| rate.parse::<u8>().ok()).collect::<Option<Vec<u8>>>()?;
    Some((name, until, PublishedRun { interval, wall_s, course }))
}

/// The runs of the archive.
#[cfg(test)]
pub(crate) mod archive {
    use super::PublishedRun;
    use rher_runs::{Evaluation, read_evaluations};

    /// A run until it was solved.
    pub(crate) struct Archived {
        pub(crate) task: String,
        /// Success rate in two consecutive evaluations at which it ended.
        pub(crate) until: f64,
        pub(crate) evaluations: Vec<Evaluation>,
    }

    impl Archived {
        /// The runs whose folders are called `TASK-KIND-seedN` and that were solved.
        pub(crate) fn all(kind: &str) -> Vec<Self> {
            let runs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/archive/runs");
            let folders = std::fs::read_dir(runs).unwrap().map(|entry| entry.unwrap().path());
            let mut folders: Vec<_> = folders.collect();
            folders.sort();
            let infix = format!("-{kind}-seed");
            let read = |folder: &std::path::PathBuf| {
                let (task, _) = folder.file_name()?.to_str()?.split_once(&infix)?;
                let until = if task == "slide" { 0.9 } else { 0.95 };
                let mut evaluations = read_evaluations(folder, None).unwrap();
                let mut two = evaluations.windows(2);
                let end = two.position(|two| two.iter().all(|it| it.reaches(until)))?;
                evaluations.truncate(end + 2);
                Some(Self { task: task.to_owned(), until, evaluations })
            };
            folders.iter().filter_map(read).collect()
        }

        /// As it is published.
        pub(crate) fn published(&self) -> PublishedRun {
            let mean = |evaluation: &Evaluation| {
                let trained: Vec<f64> = evaluation.success.iter().flatten().copied().collect();
                let mean = trained.iter().sum::<f64>() / trained.len() as f64;
                (100.0 * mean + 1e-9).round() as u8
            };
            PublishedRun {
                interval: self.evaluations[0].env_steps,
                wall_s: self.evaluations.last().unwrap().wall_s.round() as u64,
                course: self.evaluations.iter().map(mean).collect(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::archive::Archived;
    use super::*;

    #[test]
    fn what_is_published_is_in_the_archive() {
        let mut lines = Vec::new();
        for run in Archived::all("target") {
            let PublishedRun { interval, wall_s, course } = run.published();
            let rates: Vec<String> = course.iter().map(u8::to_string).collect();
            let rates = rates.join(" ");
            let line = format!("{} {} {interval} {wall_s} {rates}\n", run.task, run.until);
            lines.push((interval * course.len() as u64, wall_s, line));
        }
        lines.sort();
        let of_task = |task: &rher_envs::Task| {
            let begins = format!("{task} ");
            let lines = lines.iter().filter(|(.., line)| line.starts_with(&begins));
            lines.map(|(.., line)| line.as_str()).collect::<String>()
        };
        let expected: String = rher_envs::Task::ALL.iter().map(of_task).collect();
        assert_eq!(RUNS, expected);
        for line in RUNS.lines() {
            let (.., run) = read(line).unwrap();
            assert!(run.interval > 0 && !run.course.is_empty(), "{line}");
        }
    }
}
