//! Who acts in training, as tables that a person can check against eq. 10.

use crate::fixed::fixed;
use insta::assert_snapshot;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::config::{Method, Preset, TrainConfig, TrainPolicy};
use rher_core::explore::{ActionSource, Curriculum, Explorer, Selection};
use rher_core::goal::Stage;
use std::fmt::Write as _;

/// Two objects, four sub-tasks; α is 0.4 and β is 0.2.
fn config() -> TrainConfig {
    let mut config = Preset::Paper.config("exploration", 2);
    config.exploration.adjust_to_success = false;
    config.exploration.success_threshold = 0.8;
    config.exploration.window = 1;
    config
}

fn explorer(config: &TrainConfig, rates: [f32; 4]) -> Explorer<2> {
    let mut curriculum = Curriculum::new(&config.exploration, 4);
    curriculum.record(&rates.map(Some));
    Explorer::new(config, 4, &curriculum)
}

/// Of 20 draws that are evenly spread, which go to whom, in a scene at each stage; sub-tasks are
/// counted from 1, as the paper does.
fn shares(explorer: &Explorer<2>) -> String {
    let mut table = String::new();
    for stage in Stage::all() {
        let name = |Selection { source, stage }| match source {
            ActionSource::Random => format!("random (for {})", stage.index() + 1),
            ActionSource::Guide => format!("guide {}", stage.index() + 1),
            ActionSource::Learner => format!("learner {}", stage.index() + 1),
        };
        let draw = |draw| name(explorer.draw(stage, &mut fixed((f64::from(draw) + 0.5) / 20.0)));
        let draws: Vec<String> = (0..20).map(draw).collect();
        let runs = draws.chunk_by(|a, b| a == b).map(|run| format!("{:2} {}", run.len(), run[0]));
        writeln!(table, "stage {}: {}", stage.index() + 1, runs.collect::<Vec<_>>().join(", "))
            .unwrap();
    }
    table
}

#[test]
fn while_nothing_is_mastered_the_policy_of_the_stage_guides_to_the_next() {
    assert_snapshot!(shares(&explorer(&config(), [0.0; 4])), @r"
    stage 1:  4 random (for 2),  8 guide 1,  8 learner 2
    stage 2:  4 random (for 3),  8 guide 2,  8 learner 3
    stage 3:  4 random (for 4),  8 guide 3,  8 learner 4
    stage 4:  4 random (for 4), 16 learner 4
    ");
}

#[test]
fn a_mastered_sub_task_guides_whatever_the_stage_before_it() {
    assert_snapshot!(shares(&explorer(&config(), [0.0, 0.9, 0.0, 0.0])), @r"
    stage 1:  4 random (for 3),  8 guide 2,  8 learner 3
    stage 2:  4 random (for 3),  8 guide 2,  8 learner 3
    stage 3:  4 random (for 4),  8 guide 3,  8 learner 4
    stage 4:  4 random (for 4), 16 learner 4
    ");
    assert_snapshot!(shares(&explorer(&config(), [0.0, 0.0, 0.9, 0.0])), @r"
    stage 1:  4 random (for 4),  8 guide 3,  8 learner 4
    stage 2:  4 random (for 4),  8 guide 3,  8 learner 4
    stage 3:  4 random (for 4),  8 guide 3,  8 learner 4
    stage 4:  4 random (for 4), 16 learner 4
    ");
}

#[test]
fn once_the_last_sub_task_is_mastered_there_is_nobody_to_guide() {
    assert_snapshot!(shares(&explorer(&config(), [0.0, 0.0, 0.0, 0.9])), @r"
    stage 1:  4 random (for 4), 16 learner 4
    stage 2:  4 random (for 4), 16 learner 4
    stage 3:  4 random (for 4), 16 learner 4
    stage 4:  4 random (for 4), 16 learner 4
    ");
}

#[test]
fn plain_hindsight_has_no_guide() {
    let mut config = config();
    config.relay.method = Method::Her;
    assert_snapshot!(shares(&explorer(&config, [0.9, 0.9, 0.9, 0.0])), @r"
    stage 1:  4 random (for 4), 16 learner 4
    stage 2:  4 random (for 4), 16 learner 4
    stage 3:  4 random (for 4), 16 learner 4
    stage 4:  4 random (for 4), 16 learner 4
    ");
}

#[test]
fn a_guide_that_acts_alone_leaves_chance_its_share() {
    let mut config = config();
    config.exploration.train_policy = TrainPolicy::Guide;
    assert_snapshot!(shares(&explorer(&config, [0.0; 4])), @r"
    stage 1:  4 random (for 2), 16 guide 1
    stage 2:  4 random (for 3), 16 guide 2
    stage 3:  4 random (for 4), 16 guide 3
    stage 4:  4 random (for 4), 16 learner 4
    ");
}

#[test]
fn a_task_that_ends_sooner_has_its_last_sub_task_sooner() {
    let config = config();
    let mut curriculum = Curriculum::new(&config.exploration, 3);
    assert_snapshot!(shares(&Explorer::new(&config, 3, &curriculum)), @r"
    stage 1:  4 random (for 2),  8 guide 1,  8 learner 2
    stage 2:  4 random (for 3),  8 guide 2,  8 learner 3
    stage 3:  4 random (for 3), 16 learner 3
    stage 4:  4 random (for 3), 16 learner 3
    ");
    curriculum.record(&[Some(0.0), Some(0.0), Some(0.9)]);
    assert_snapshot!(shares(&Explorer::new(&config, 3, &curriculum)), @r"
    stage 1:  4 random (for 3), 16 learner 3
    stage 2:  4 random (for 3), 16 learner 3
    stage 3:  4 random (for 3), 16 learner 3
    stage 4:  4 random (for 3), 16 learner 3
    ");
}

/// AAES: chance has the less to do the better the sub-task that is to be learned already is.
#[test]
fn success_of_the_learner_takes_from_chance() {
    let mut config = config();
    config.exploration.adjust_to_success = true;
    config.exploration.success_threshold = 1.0;
    assert_snapshot!(shares(&explorer(&config, [0.0, 0.5, 0.75, 1.0])), @r"
    stage 1:  2 random (for 2),  8 guide 1, 10 learner 2
    stage 2:  1 random (for 3),  8 guide 2, 11 learner 3
    stage 3:  8 guide 3, 12 learner 4
    stage 4: 20 learner 4
    ");
}

/// AAES: and the less noise is put on the actions of a sub-task the better it is.
#[test]
fn success_takes_from_the_noise() {
    let mut config = config();
    config.exploration.noise = 0.5;
    let noise = |config: &TrainConfig| {
        let explorer = explorer(config, [0.0, 0.5, 0.75, 1.0]);
        Stage::all().map(|stage| explorer.noise(stage)).collect::<Vec<_>>()
    };
    assert_eq!(noise(&config), [0.5; 4]);
    config.exploration.adjust_to_success = true;
    assert_eq!(noise(&config), [0.5, 0.25, 0.125, 0.0]);
}

#[test]
fn a_share_ends_where_the_next_begins() {
    let mut config = config();
    (config.exploration.random, config.exploration.guide) = (0.25, 0.5);
    let explorer = explorer(&config, [0.0; 4]);
    let source = |share| explorer.draw(Stage::FIRST, &mut fixed(share)).source;
    let just_below = |share: f64| source(share - 1e-6);
    assert_eq!((just_below(0.25), source(0.25)), (ActionSource::Random, ActionSource::Guide));
    assert_eq!((just_below(0.75), source(0.75)), (ActionSource::Guide, ActionSource::Learner));
}

#[test]
fn a_random_action_is_kept_for_as_long_as_set() {
    let kept = |random_steps, share| {
        let mut config = config();
        config.exploration.random_steps = random_steps;
        let mut rng = fixed(share);
        (explorer(&config, [0.0; 4]).keeps_random(&mut rng), rng.draws)
    };
    assert_eq!(kept(4.0, 0.0), (false, 1));
    assert_eq!(kept(4.0, 0.25 - 1e-6), (false, 1), "one of four is the last");
    assert_eq!(kept(4.0, 0.25), (true, 1));
    assert_eq!(kept(4.0, 0.99), (true, 1));
    assert_eq!(kept(1.0, 0.99), (false, 0), "nothing is kept, so nothing is drawn");
}

/// However long random actions are kept, everyone acts in the share of steps that is set.
#[test]
fn everyone_acts_as_often_as_set() {
    for random_steps in [1.0, 4.0] {
        let mut config = Preset::Paper.config("shares", 1);
        config.exploration.random_steps = random_steps;
        let explorer = Explorer::new(&config, 2, &Curriculum::new(&config.exploration, 2));
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let (mut counts, mut drawn) = ([0_u32; 3], 0);
        let mut last = ActionSource::Learner;
        for _ in 0..100_000 {
            if last != ActionSource::Random || !explorer.keeps_random(&mut rng) {
                last = explorer.draw(Stage::<1>::FIRST, &mut rng).source;
                drawn += u32::from(last == ActionSource::Random);
            }
            counts[last as usize] += 1;
        }
        let [guided, learned, random] = counts.map(|count| f64::from(count) / 100_000.0);
        let near = |share: f64, expected: f64| (share - expected).abs() < 0.01;
        assert!(near(guided, 0.4) && near(learned, 0.4) && near(random, 0.2), "{counts:?}");
        let kept_for = f64::from(counts[2]) / f64::from(drawn);
        assert!((kept_for / f64::from(random_steps) - 1.0).abs() < 0.05, "{kept_for} steps");
    }
}

/// One line for each evaluation: what it found, what the curriculum makes of it, and who guides.
fn history(threshold: f32, window: usize, found: &[[Option<f32>; 4]]) -> String {
    let mut config = config().exploration;
    (config.success_threshold, config.window) = (threshold, window);
    let mut curriculum = Curriculum::new(&config, 4);
    let mut table = String::new();
    for found in found {
        curriculum.record(found);
        let found = found.map(|rate| rate.map_or("  - ".to_owned(), |rate| format!("{rate:.2}")));
        let rates = [0, 1, 2, 3].map(|subtask| format!("{:.3}", curriculum.rate(subtask)));
        let (found, rates, guide) = (found.join(" "), rates.join(" "), curriculum.guide() + 1);
        writeln!(table, "{found} -> {rates}, guide {guide}").unwrap();
    }
    table
}

#[test]
fn a_sub_task_is_mastered_by_the_mean_over_the_window() {
    let found = [
        [Some(1.0), Some(0.0), Some(0.0), None],
        [Some(1.0), Some(0.5), Some(0.0), None],
        [Some(1.0), Some(1.0), Some(1.0), None],
        [Some(0.0), Some(1.0), Some(1.0), None],
        [Some(0.0), Some(1.0), Some(1.0), None],
        [Some(0.0), Some(0.0), Some(1.0), None],
        [Some(0.0), Some(0.0), Some(0.0), None],
        [Some(0.0), Some(0.0), Some(0.0), None],
    ];
    assert_snapshot!(history(0.6, 3, &found), @r"
    1.00 0.00 0.00   -  -> 0.500 0.000 0.000 0.000, guide 1
    1.00 0.50 0.00   -  -> 0.667 0.167 0.000 0.000, guide 1
    1.00 1.00 1.00   -  -> 1.000 0.500 0.333 0.000, guide 1
    0.00 1.00 1.00   -  -> 0.667 0.833 0.667 0.000, guide 3
    0.00 1.00 1.00   -  -> 0.333 1.000 1.000 0.000, guide 3
    0.00 0.00 1.00   -  -> 0.000 0.667 1.000 0.000, guide 3
    0.00 0.00 0.00   -  -> 0.000 0.333 0.667 0.000, guide 3
    0.00 0.00 0.00   -  -> 0.000 0.000 0.333 0.000, guide 1
    ");
}

#[test]
fn mastered_is_above_the_threshold_and_not_at_it() {
    let all = |rate| [Some(rate); 4];
    assert_snapshot!(history(0.5, 1, &[all(0.5), all(0.51)]), @r"
    0.50 0.50 0.50 0.50 -> 0.500 0.500 0.500 0.500, guide 1
    0.51 0.51 0.51 0.51 -> 0.510 0.510 0.510 0.510, guide 4
    ");
    assert_snapshot!(history(1.0, 1, &[all(1.0)]), @"1.00 1.00 1.00 1.00 -> 1.000 1.000 1.000 1.000, guide 1");
}
