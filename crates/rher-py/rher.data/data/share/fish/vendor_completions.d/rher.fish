# Print an optspec for argparse to handle cmd's options that are independent of any subcommand.
function __fish_rher_global_optspecs
    string join \n h/help V/version
end

function __fish_rher_needs_command
    # Figure out if the current invocation already has a command.
    set -l cmd (commandline -opc)
    set -e cmd[1]
    argparse -s (__fish_rher_global_optspecs) -- $cmd 2>/dev/null
    or return
    if set -q argv[1]
        # Also print the command, so this can be used to figure out what it is.
        echo $argv[1]
        return 1
    end
    return 0
end

function __fish_rher_using_subcommand
    set -l cmd (__fish_rher_needs_command)
    test -z "$cmd"
    and return 1
    contains -- $cmd[1] $argv
end

complete -c rher -n "__fish_rher_needs_command" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_needs_command" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_needs_command" -f -a "tasks" -d 'List the tasks: what there is to do, and how long it usually takes to learn'
complete -c rher -n "__fish_rher_needs_command" -f -a "train" -d 'Train a policy, or resume a run from its checkpoint'
complete -c rher -n "__fish_rher_needs_command" -f -a "sweep" -d 'Train with every combination of settings and seeds, several runs at a time'
complete -c rher -n "__fish_rher_needs_command" -f -a "reproduce" -d 'Repeat an experiment of the paper'
complete -c rher -n "__fish_rher_needs_command" -f -a "eval" -d 'Measure the success rate of a policy, with a 95 % confidence interval'
complete -c rher -n "__fish_rher_needs_command" -f -a "play" -d 'Play episodes of a policy, and draw or record them'
complete -c rher -n "__fish_rher_needs_command" -f -a "replay" -d 'List the episodes of a recording, or verify that they reproduce bit for bit'
complete -c rher -n "__fish_rher_needs_command" -f -a "export" -d 'Write a policy as an ONNX model, or its episodes as a dataset for Minari or LeRobot'
complete -c rher -n "__fish_rher_needs_command" -f -a "card" -d 'Write a model card: a policy with its numbers, a moving picture and its settings'
complete -c rher -n "__fish_rher_needs_command" -f -a "runs" -d 'List the runs below a folder: how far they are, and whether they go on'
complete -c rher -n "__fish_rher_needs_command" -f -a "stats" -d 'Compare runs: sample efficiency, final success, confidence intervals'
complete -c rher -n "__fish_rher_needs_command" -f -a "plot" -d 'Draw learning curves, with those that the authors published'
complete -c rher -n "__fish_rher_needs_command" -f -a "report" -d 'Write one HTML page about runs: curves, tables, an episode, settings'
complete -c rher -n "__fish_rher_needs_command" -f -a "config" -d 'Print every setting of a run as TOML, for `rher train --config`'
complete -c rher -n "__fish_rher_needs_command" -f -a "doctor" -d 'Say what this machine is, and whether it computes the same bits as every other'
complete -c rher -n "__fish_rher_needs_command" -f -a "bench" -d 'Measure the speed of this machine'
complete -c rher -n "__fish_rher_needs_command" -f -a "completions" -d 'Print what completes commands and options in a shell'
complete -c rher -n "__fish_rher_needs_command" -f -a "man" -d 'Write manual pages, one for each command'
complete -c rher -n "__fish_rher_needs_command" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c rher -n "__fish_rher_using_subcommand tasks" -l json -d 'Print JSON: an array with one object per task, also with its dimensions, the length of its episodes, its tolerances and the names of all numbers'
complete -c rher -n "__fish_rher_using_subcommand tasks" -s h -l help -d 'Print help'
complete -c rher -n "__fish_rher_using_subcommand tasks" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand train" -l preset -d 'Preset to start from; `fast` also applies the recipe of the task [default: fast]' -r -f -a "fast\t'Reaches the success rate in the least time on the user\'s machine'
sample-efficient\t'Reaches the success rate in the fewest environment steps'
paper\t'The published settings'"
complete -c rher -n "__fish_rher_using_subcommand train" -l config -d 'TOML file with settings to change; `rher config` prints all of them' -r -F
complete -c rher -n "__fish_rher_using_subcommand train" -l set -d 'A setting to change, as in `--set agent.discount=0.98`; may be repeated; `--set help` lists them' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l method -d 'Training method [default: rher]' -r -f -a "rher\t'Relay hindsight experience replay: trains every sub-task, with guided exploration'
her\t'Plain hindsight experience replay, the baseline: trains the last sub-task only, without a guide'"
complete -c rher -n "__fish_rher_using_subcommand train" -l seed -d 'Seed of all random numbers of the run' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l env-steps -d 'End after this many environment steps of training; evaluations do not count' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l until -d 'End after two consecutive evaluations with at least this success rate; 0 never ends the run' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l engine -d 'Compute engine of the networks' -r -f -a "burn\t'Burn\'s automatic differentiation: the reference implementation'
fused\t'Explicit forward and backward passes over preallocated buffers: the fast implementation'"
complete -c rher -n "__fish_rher_using_subcommand train" -l precision -d 'Precision of the networks\' matrix products' -r -f -a "f32\t'Numbers of 32 bits'
bf16\t'Numbers rounded to 16 bits (bfloat16), with sums of 32 bits: two thirds of the time of `f32` on a processor with AVX512-BF16; the same result, in up to a tenth more time than `f32`, on any other. Only the engine `fused` has it'"
complete -c rher -n "__fish_rher_using_subcommand train" -l envs -d 'Number of environments that step side by side between updates; it changes the result' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l workers -d 'Number of threads, which never changes the result [default: one for each core]' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l out -d 'Run folder to create; by default `runs/<TASK>-<METHOD>-<PRESET>-<SEED>`' -r -F
complete -c rher -n "__fish_rher_using_subcommand train" -l from -d 'Start with the networks of the run in this folder, which may be of another task' -r -F
complete -c rher -n "__fish_rher_using_subcommand train" -l record-every -d 'Record every N-th training episode for Foxglove, beginning with the first' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l resume -d 'Resume the run in this folder, as if it had never stopped' -r -F
complete -c rher -n "__fish_rher_using_subcommand train" -l max-wall -d 'Save the run and end with exit status 16 after this time, as in `90s`, `55m` or `4h`' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l parent -d 'Process that started this one, with which it ends: for the program\'s own processes' -r
complete -c rher -n "__fish_rher_using_subcommand train" -l tensorboard -d 'Write event files for `tensorboard --logdir runs`, with the numbers of `metrics.jsonl`'
complete -c rher -n "__fish_rher_using_subcommand train" -s q -l quiet -d 'Print errors only'
complete -c rher -n "__fish_rher_using_subcommand train" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand train" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand sweep" -l set -d 'A setting and its values, as in `--set relay.mirror=0,0.5`; may be repeated; `--set help` lists the settings' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l preset -d 'Preset to start from' -r -f -a "fast\t'Reaches the success rate in the least time on the user\'s machine'
sample-efficient\t'Reaches the success rate in the fewest environment steps'
paper\t'The published settings'"
complete -c rher -n "__fish_rher_using_subcommand sweep" -l config -d 'TOML file with settings that all runs share' -r -F
complete -c rher -n "__fish_rher_using_subcommand sweep" -l method -d 'Training method [default: rher]' -r -f -a "rher\t'Relay hindsight experience replay: trains every sub-task, with guided exploration'
her\t'Plain hindsight experience replay, the baseline: trains the last sub-task only, without a guide'"
complete -c rher -n "__fish_rher_using_subcommand sweep" -l seeds -d 'Seeds for every combination of settings, as in `1-5` or `1,2,7`' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l env-steps -d 'End every run after this many environment steps' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l until -d 'End a run after two consecutive evaluations with at least this success rate; 0 never ends it' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l out -d 'Folder of the run folders; by default `runs/sweep-<TASK>`' -r -F
complete -c rher -n "__fish_rher_using_subcommand sweep" -l plan -d 'Plan: with tasks it is written, and nothing is trained; without, its cells are trained' -r -F
complete -c rher -n "__fish_rher_using_subcommand sweep" -l cell -d 'Train this cell of the plan only, or continue it; the first cell is 0' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l cell-from -d 'Train the cell whose number is in this environment variable, such as `SLURM_ARRAY_TASK_ID`' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l workers -d 'Number of threads of a cell, which never changes the result' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l max-wall -d 'Save a cell and end with exit status 16 after this time, as in `90s`, `55m` or `4h`' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l status -d 'Say how far the cells of this plan are, and train nothing' -r -F
complete -c rher -n "__fish_rher_using_subcommand sweep" -l jobs -d 'Number of runs at a time [default: one for each core]' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l parent -d 'Process that started this one, with which it ends: for the program\'s own processes' -r
complete -c rher -n "__fish_rher_using_subcommand sweep" -l json -d 'Print JSON: an array with one object per combination of settings, or the status as one object'
complete -c rher -n "__fish_rher_using_subcommand sweep" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand sweep" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l preset -d 'Preset to start from [default: paper; for `shipped` fast]' -r -f -a "fast\t'Reaches the success rate in the least time on the user\'s machine'
sample-efficient\t'Reaches the success rate in the fewest environment steps'
paper\t'The published settings'"
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l out -d 'Folder of the run folders; by default `runs/reproduce-<NAME>`' -r -F
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l seeds -d 'Seeds for every combination of settings, as in `1-5` or `1,2,7` [default: 1-3; `shipped` has seed 1 alone]' -r
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l env-steps -d 'End every run after this many environment steps' -r
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l jobs -d 'Number of runs at a time [default: one for each core]' -r
complete -c rher -n "__fish_rher_using_subcommand reproduce" -l json -d 'Print JSON: an array with one object per combination of settings, or the status as one object'
complete -c rher -n "__fish_rher_using_subcommand reproduce" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand reproduce" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand eval" -l episodes -d 'Number of episodes for each sub-task' -r
complete -c rher -n "__fish_rher_using_subcommand eval" -l seed -d 'Seed of the evaluation episodes [default: one that training has not evaluated with]' -r
complete -c rher -n "__fish_rher_using_subcommand eval" -l set -d 'A setting of the environments to change, as in `--set randomize.action_delay=[0,2]`; may be repeated' -r
complete -c rher -n "__fish_rher_using_subcommand eval" -l workers -d 'Number of threads, which never changes the result [default: one for each core]' -r
complete -c rher -n "__fish_rher_using_subcommand eval" -l json -d 'Print JSON: one object'
complete -c rher -n "__fish_rher_using_subcommand eval" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand eval" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand play" -l episodes -d 'Number of episodes to play' -r
complete -c rher -n "__fish_rher_using_subcommand play" -l seed -d 'Seed of the evaluation episodes, as in `rher eval`' -r
complete -c rher -n "__fish_rher_using_subcommand play" -l mcap -d 'Record the episodes in this MCAP file' -r -F
complete -c rher -n "__fish_rher_using_subcommand play" -l film -l gif -d 'Draw the episodes as one film: .gif, .mp4 or .webm' -r
complete -c rher -n "__fish_rher_using_subcommand play" -l png-dir -d 'Draw every step as a PNG file in this folder' -r -F
complete -c rher -n "__fish_rher_using_subcommand play" -l camera -d 'From where to draw: `close` is `corner`, but as near as each episode allows' -r -f -a "corner\t''
front\t''
side\t''
top\t''
close\t''"
complete -c rher -n "__fish_rher_using_subcommand play" -l size -d 'Width and height of pictures, in pixels' -r
complete -c rher -n "__fish_rher_using_subcommand play" -l trim -d 'Cut each episode of the film shortly after its success'
complete -c rher -n "__fish_rher_using_subcommand play" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand play" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand replay" -l verify -d 'Simulate every episode again, and compare it'
complete -c rher -n "__fish_rher_using_subcommand replay" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand replay" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand export" -l format -d 'What to write' -r -f -a "onnx\t'The policy as an ONNX model, and a description of its numbers'
minari\t'A Minari dataset, in its Parquet storage'
lerobot\t'A LeRobot dataset, version 3.0'"
complete -c rher -n "__fish_rher_using_subcommand export" -l out -d 'Folder of the dataset, which must not exist yet, or file of the model [default for a model: policy.onnx]' -r -F
complete -c rher -n "__fish_rher_using_subcommand export" -l dataset-id -d 'Identity of a Minari dataset, as in `rher/push-v1` (by default, that of the task)' -r
complete -c rher -n "__fish_rher_using_subcommand export" -l episodes -d 'Number of episodes to play, or of a recording\'s first episodes [default: 100, or all of them]' -r
complete -c rher -n "__fish_rher_using_subcommand export" -l seed -d 'Seed of the episodes that are played, as in `rher eval` [default: 0]' -r
complete -c rher -n "__fish_rher_using_subcommand export" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand export" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand card" -s o -l out -d 'Folder of the card, which must not exist yet' -r -F
complete -c rher -n "__fish_rher_using_subcommand card" -l episodes -d 'Number of episodes for each sub-task by which the policy is judged' -r
complete -c rher -n "__fish_rher_using_subcommand card" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand card" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand runs" -l json -d 'Print JSON: an array with one object per run'
complete -c rher -n "__fish_rher_using_subcommand runs" -s h -l help -d 'Print help'
complete -c rher -n "__fish_rher_using_subcommand runs" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand stats" -s o -l out -d 'Image file to write, too, with performance profiles and probabilities of improvement; its name ends in .svg or .png' -r -F
complete -c rher -n "__fish_rher_using_subcommand stats" -l markdown -d 'Print Markdown tables'
complete -c rher -n "__fish_rher_using_subcommand stats" -l json -d 'Print JSON: one object'
complete -c rher -n "__fish_rher_using_subcommand stats" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand stats" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand plot" -s o -l out -d 'Image file to write; its name ends in .svg or .png' -r -F
complete -c rher -n "__fish_rher_using_subcommand plot" -l x -d 'Horizontal axis' -r -f -a "steps\t'Environment steps of training'
time\t'Wall clock'"
complete -c rher -n "__fish_rher_using_subcommand plot" -l measure -d 'Statistic of several runs that a line shows' -r -f -a "mean\t'The mean'
iqm\t'The interquartile mean'"
complete -c rher -n "__fish_rher_using_subcommand plot" -l columns -d 'Panels beside each other [default: at most 3]' -r
complete -c rher -n "__fish_rher_using_subcommand plot" -l title -d 'Title above the panels' -r
complete -c rher -n "__fish_rher_using_subcommand plot" -l no-subtasks -d 'Leave out the panels of sub-tasks'
complete -c rher -n "__fish_rher_using_subcommand plot" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand plot" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand report" -s o -l out -d 'Page to write' -r -F
complete -c rher -n "__fish_rher_using_subcommand report" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand report" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand config" -l preset -d 'Preset to start from; `fast` also applies the recipe of the task [default: fast]' -r -f -a "fast\t'Reaches the success rate in the least time on the user\'s machine'
sample-efficient\t'Reaches the success rate in the fewest environment steps'
paper\t'The published settings'"
complete -c rher -n "__fish_rher_using_subcommand config" -l config -d 'TOML file with settings to change; `rher config` prints all of them' -r -F
complete -c rher -n "__fish_rher_using_subcommand config" -l set -d 'A setting to change, as in `--set agent.discount=0.98`; may be repeated; `--set help` lists them' -r
complete -c rher -n "__fish_rher_using_subcommand config" -l method -d 'Training method [default: rher]' -r -f -a "rher\t'Relay hindsight experience replay: trains every sub-task, with guided exploration'
her\t'Plain hindsight experience replay, the baseline: trains the last sub-task only, without a guide'"
complete -c rher -n "__fish_rher_using_subcommand config" -l seed -d 'Seed of all random numbers of the run' -r
complete -c rher -n "__fish_rher_using_subcommand config" -l env-steps -d 'End after this many environment steps of training; evaluations do not count' -r
complete -c rher -n "__fish_rher_using_subcommand config" -l until -d 'End after two consecutive evaluations with at least this success rate; 0 never ends the run' -r
complete -c rher -n "__fish_rher_using_subcommand config" -l engine -d 'Compute engine of the networks' -r -f -a "burn\t'Burn\'s automatic differentiation: the reference implementation'
fused\t'Explicit forward and backward passes over preallocated buffers: the fast implementation'"
complete -c rher -n "__fish_rher_using_subcommand config" -l precision -d 'Precision of the networks\' matrix products' -r -f -a "f32\t'Numbers of 32 bits'
bf16\t'Numbers rounded to 16 bits (bfloat16), with sums of 32 bits: two thirds of the time of `f32` on a processor with AVX512-BF16; the same result, in up to a tenth more time than `f32`, on any other. Only the engine `fused` has it'"
complete -c rher -n "__fish_rher_using_subcommand config" -l envs -d 'Number of environments that step side by side between updates; it changes the result' -r
complete -c rher -n "__fish_rher_using_subcommand config" -l explain -d 'Explain every setting: what it does, its values and its range'
complete -c rher -n "__fish_rher_using_subcommand config" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand config" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand doctor" -l bits -d 'Compute a little of push, dpush and drawer-box, and compare the hashes with those that every machine must find'
complete -c rher -n "__fish_rher_using_subcommand doctor" -l json -d 'Print JSON: an object'
complete -c rher -n "__fish_rher_using_subcommand doctor" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand doctor" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand bench; and not __fish_seen_subcommand_from env update help" -s h -l help -d 'Print help'
complete -c rher -n "__fish_rher_using_subcommand bench; and not __fish_seen_subcommand_from env update help" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand bench; and not __fish_seen_subcommand_from env update help" -f -a "env" -d 'Environment steps per CPU-second with random actions, of one environment and of many'
complete -c rher -n "__fish_rher_using_subcommand bench; and not __fish_seen_subcommand_from env update help" -f -a "update" -d 'Milliseconds per update of the networks'
complete -c rher -n "__fish_rher_using_subcommand bench; and not __fish_seen_subcommand_from env update help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from env" -l task -d 'Task to measure; may be repeated [default: every task]' -r -f -a "reach\t''
push\t''
pick\t''
slide\t''
insert\t''
obstacle-push\t''
drawer\t''
cue-push\t''
dpush\t''
stack\t''
drawer-box\t''
tpush\t''
tstack\t''"
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from env" -l one-thread -d 'Print the rate of one thread only: for the program\'s own processes'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from env" -l json -d 'Print JSON: an array with one object per task'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from env" -s h -l help -d 'Print help'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from env" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l batch -d 'Rows in the batch; may be repeated [default: 128, 256, 1024, 2048]' -r
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l inputs -d 'Dimension of the network input; may be repeated [default: 31, 81]' -r
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l threads -d 'Threads of the learner; may be repeated [default: 1, 2]' -r
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l engine -d 'Engine to measure [default: every engine]' -r -f -a "burn\t'Burn\'s automatic differentiation: the reference implementation'
fused\t'Explicit forward and backward passes over preallocated buffers: the fast implementation'"
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l precision -d 'Precision to measure; may be repeated [default: f32]' -r -f -a "f32\t'Numbers of 32 bits'
bf16\t'Numbers rounded to 16 bits (bfloat16), with sums of 32 bits: two thirds of the time of `f32` on a processor with AVX512-BF16; the same result, in up to a tenth more time than `f32`, on any other. Only the engine `fused` has it'"
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -l json -d 'Print JSON: an array with one object per row'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from update" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from help" -f -a "env" -d 'Environment steps per CPU-second with random actions, of one environment and of many'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from help" -f -a "update" -d 'Milliseconds per update of the networks'
complete -c rher -n "__fish_rher_using_subcommand bench; and __fish_seen_subcommand_from help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c rher -n "__fish_rher_using_subcommand completions" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand completions" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand man" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c rher -n "__fish_rher_using_subcommand man" -s V -l version -d 'Print version'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "tasks" -d 'List the tasks: what there is to do, and how long it usually takes to learn'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "train" -d 'Train a policy, or resume a run from its checkpoint'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "sweep" -d 'Train with every combination of settings and seeds, several runs at a time'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "reproduce" -d 'Repeat an experiment of the paper'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "eval" -d 'Measure the success rate of a policy, with a 95 % confidence interval'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "play" -d 'Play episodes of a policy, and draw or record them'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "replay" -d 'List the episodes of a recording, or verify that they reproduce bit for bit'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "export" -d 'Write a policy as an ONNX model, or its episodes as a dataset for Minari or LeRobot'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "card" -d 'Write a model card: a policy with its numbers, a moving picture and its settings'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "runs" -d 'List the runs below a folder: how far they are, and whether they go on'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "stats" -d 'Compare runs: sample efficiency, final success, confidence intervals'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "plot" -d 'Draw learning curves, with those that the authors published'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "report" -d 'Write one HTML page about runs: curves, tables, an episode, settings'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "config" -d 'Print every setting of a run as TOML, for `rher train --config`'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "doctor" -d 'Say what this machine is, and whether it computes the same bits as every other'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "bench" -d 'Measure the speed of this machine'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "completions" -d 'Print what completes commands and options in a shell'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "man" -d 'Write manual pages, one for each command'
complete -c rher -n "__fish_rher_using_subcommand help; and not __fish_seen_subcommand_from tasks train sweep reproduce eval play replay export card runs stats plot report config doctor bench completions man help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c rher -n "__fish_rher_using_subcommand help; and __fish_seen_subcommand_from bench" -f -a "env" -d 'Environment steps per CPU-second with random actions, of one environment and of many'
complete -c rher -n "__fish_rher_using_subcommand help; and __fish_seen_subcommand_from bench" -f -a "update" -d 'Milliseconds per update of the networks'
