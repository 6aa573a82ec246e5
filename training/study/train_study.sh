#!/usr/bin/env bash
# Trains every policy of the study again: the fault at eight alphas, sliding_mode and circuit, with TQC and TD3, and a
# transfer of the fault's alpha 8 to a 30 x 30 mesh.
#   training/study/train_study.sh [OUT]
# OUT (default output/study_training) gets all seeds, learning curves and figures, and in OUT/policies the policy of the
# best seed of each: highest mean return on held-out random instances (choose_seed.py). What is there already is not
# trained again, so an interrupted run goes on. Copy OUT/policies/*.h5 to training/study/policies to ship them (its page
# says which of those there are others), OUT/NAME_curves.png to output/figures/training_NAME.png.
#   RANKS (default: processors)  trainings side by side
#   SEEDS (default "1 2")        seeds of every training; those of alpha 2 and 8 also get MORE_SEEDS (default "3")
#   STEPS (default 20000)        environment steps of a training; TRANSFER_STEPS (default 1000) more for the transfer
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
train=${TRAIN:-$root/build/bin/train}
out=${1:-$root/output/study_training}
ranks=${RANKS:-$(nproc)}
read -ra seeds <<<"${SEEDS:-1 2}"
read -ra more <<<"${MORE_SEEDS-3}"
steps=${STEPS:-20000}
python=${SLIPSTEP_PYTHON:-python3}
"$python" -c 'import h5py, matplotlib' 2>/dev/null || python=/usr/bin/python3
. "$root/tests/setup.sh"
slipstep_environment
[ -x "$train" ] || { echo "train_study: no program $train; build first" >&2; exit 1; }
train=$(realpath "$train")
mkdir -p "$out/policies"
cd "$out"

join() { local IFS=,; echo "$*"; }

# complete POLICY.h5: is it there, with its learning curve, which a training writes last?
complete() { [ -s "$1" ] && [ -s "log_$1" ]; }

# sweep NAME "ALPHAS" "SEEDS" -- options: files NAME_alphaA_seedS.h5, and with log_ and checkpoint_ before it
sweep() {
  local name=$1 alphas=$2 list=$3 alpha seed
  shift 4
  for seed in $list; do
    for alpha in $alphas; do
      complete "${name}_alpha${alpha}_seed$seed.h5" && [ -e "checkpoint_${name}_alpha${alpha}_seed$seed.h5" ] || missing+=("$alpha $seed")
    done
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  # all at once, whose names train makes itself; a single one, and what an interruption left, one by one
  if [ ${#missing[@]} -gt 1 ] && [ ${#missing[@]} = "$(($(wc -w <<<"$alphas") * $(wc -w <<<"$list")))" ]; then
    "${launch[@]}" "$train" "$@" -train_alpha "$(join $alphas)" -train_seed "$(join $list)" "${common[@]}" \
      -train_output "$name.h5" -train_log "log_$name.h5" -train_checkpoint "checkpoint_$name.h5"
  else
    for pair in "${missing[@]}"; do
      read -r alpha seed <<<"$pair"
      local end=_alpha${alpha}_seed$seed.h5
      "$train" "$@" -train_alpha "$alpha" -train_seed "$seed" "${common[@]}" -train_output "$name$end" \
        -train_log "log_$name$end" -train_checkpoint "checkpoint_$name$end"
    done
  fi
  missing=()
}

# choose NAME ALPHA OUTPUT: the best of all seeds there are
choose() {
  local pairs=() file
  for file in "$1_alpha$2_seed"*.h5; do pairs+=("log_$file=$file"); done
  "$python" "$root/training/study/choose_seed.py" "policies/$3.h5" "${pairs[@]}" | tee -a choice.txt
}

missing=()
launch=(mpirun --oversubscribe -n "$ranks")
common=(-train_random -train_reward balanced -train_steps "$steps" -train_max_attempts 300 -train_evaluate_interval 2000
        -train_evaluate_episodes 24 -train_progress 5000 -train_checkpoint_interval 0)
alphas="2 8 1 4 0.5 16 32 128"
: >choice.txt
sweep fault_tqc "$alphas" "${seeds[*]}" --
[ ${#more[@]} = 0 ] || sweep fault_tqc "2 8" "${more[*]}" --
sweep fault_td3 "1 2" "${seeds[*]}" -- -train_algorithm td3
for problem in sliding_mode circuit; do
  for algorithm in tqc td3; do
    sweep ${problem}_$algorithm "2" "${seeds[*]}" -- -train_problem $problem -train_algorithm $algorithm
    choose ${problem}_$algorithm 2 ${problem}_$algorithm
  done
done
for alpha in $alphas; do choose fault_tqc "$alpha" "fault_tqc_alpha$alpha"; done
for alpha in 1 2; do choose fault_td3 $alpha fault_td3_alpha$alpha; done

# The transfer goes on from the chosen seed of alpha 8, on the 3 km fault itself. Continuations of a mesh are dear:
# longer steps.
seed=$(sed -n 's/^fault_tqc_alpha8.h5 *seed \([0-9]*\):.*taken$/\1/p' choice.txt)
transfer=fault_tqc_alpha8_mesh30_seed$seed.h5
if ! complete "$transfer"; then
  total=$((steps + ${TRANSFER_STEPS:-1000}))
  "$train" -train_reward balanced -train_alpha 8 -train_seed "$seed" -fault_nx 30 -fault_nz 30 -train_transfer \
    -train_resume "checkpoint_fault_tqc_alpha8_seed$seed.h5" -train_steps $total -train_max_attempts 100 \
    -train_continuation_step 0.25 -train_evaluate_interval 200 -train_progress 100 \
    -train_output "$transfer" -train_log "log_$transfer"
fi
cp "$transfer" policies/fault_tqc_alpha8_mesh30.h5

curves=() # without the transfer's, which begins where another ends
for alpha in $alphas; do curves+=("log_fault_tqc_alpha${alpha}_seed"*.h5); done
"$python" "$root/src/package/program.py" plot-training "${curves[@]}" log_fault_td3_alpha*.h5 --figure fault_curves.png
for problem in sliding_mode circuit; do
  "$python" "$root/src/package/program.py" plot-training log_${problem}_t*_alpha*.h5 --figure ${problem}_curves.png
done
cat choice.txt
