"""The choice of a seed, and the script that trains the study, with a stand-in for the program train."""

import os
import shutil
import subprocess
import sys
import unittest

from scripts import SOURCE, ScriptTest

import h5py
import numpy as np

CHOOSE = os.path.join(SOURCE, "training", "study", "choose_seed.py")
SCRIPT = os.path.join(SOURCE, "training", "study", "train_study.sh")


def write_log(path, seed, returns):
    with h5py.File(path, "w") as file:
        file.attrs["seed"] = seed
        for name, values in (("step", 10.0 * np.arange(len(returns))), ("return", returns),
                             ("length", np.full(len(returns), 12.0)),
                             ("error", np.full(len(returns), 0.01))):
            file[f"evaluations/{name}"] = np.asarray(values, dtype=float)


class ChooseSeedTest(ScriptTest):
    def setUp(self):
        super().setUp()
        for seed, returns in ((1, (-9, -5, -7)), (2, (-6, np.nan, -4)), (3, (-4.5, -4.25))):
            write_log(self.path(f"log{seed}.h5"), seed, returns)
            self.put(f"p{seed}.h5", f"policy {seed}")

    def choose(self, *pairs):
        return subprocess.run([sys.executable, CHOOSE, self.path("out.h5"), *pairs], capture_output=True, text=True)

    def test_takes_the_highest_return_of_any_evaluation(self):
        done = self.choose(*(f"{self.path(f'log{seed}.h5')}={self.path(f'p{seed}.h5')}" for seed in (1, 2, 3)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.content("out.h5"), "policy 2")  # its evaluation that is no number counts for nothing
        self.assertRegex(done.stdout, r"seed 2: return -4.000, 12.0 attempts, error 1.00 % at step 20  taken\n")
        self.assertRegex(done.stdout, r"spread over 3 seeds: -5.000 to -4.000\n")

    def test_refuses_what_is_missing_and_keeps_the_old_choice(self):
        write_log(self.path("empty.h5"), 4, ())
        self.put("out.h5", "old")
        one = self.path("log1.h5")
        for pairs, words in (((f"{one}={self.path('none.h5')}",), "none.h5"), ((f"{self.path('no.h5')}=x",), "no.h5"),
                             ((f"{self.path('empty.h5')}=x",), "empty.h5"),
                             ((one,), "LOG.h5=POLICY.h5")):
            done = self.choose(*pairs)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, f"^choose_seed: .*{words}")
            self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(self.content("out.h5"), "old")


# Writes the policy, learning curve and checkpoint that its options name, with a return that is highest for one seed,
# and notes the call.
TRAIN = '''#!{python}
import os, sys
import h5py
import numpy as np
words = sys.argv[1:]
given = {{word: words[i + 1] if i + 1 < len(words) else "" for i, word in enumerate(words) if word.startswith("-")}}
with open("calls.txt", "a") as file:
    print(*words, file=file)
alphas, seeds = given["-train_alpha"].split(","), given["-train_seed"].split(",")
for alpha in alphas:
    for seed in seeds:
        end = f"_alpha{{alpha}}_seed{{seed}}.h5" if len(alphas) * len(seeds) > 1 else ".h5"
        with open(given["-train_output"][:-3] + end, "w") as file:
            file.write(f"{{alpha}} {{seed}}" + " transfer" * ("-train_transfer" in given))
        if "-train_checkpoint" in given:
            open(given["-train_checkpoint"][:-3] + end, "w").close()
        with h5py.File(given["-train_log"][:-3] + end, "w") as file:
            file.attrs.update({{"alpha": float(alpha), "seed": int(seed),
                                "algorithm": given.get("-train_algorithm", "tqc"),
                                "problem": given.get("-train_problem", "fault"),
                                "reward": "balanced", "error": "error"}})
            for group in ("episodes", "evaluations"):
                for name, values in (("step", [0, 10]), ("return", [-9, -8 + 0.1 * {best} * (seed == "{best}")]),
                                     ("length", [9, 9]), ("error", [0.1, 0.1])):
                    file[f"{{group}}/{{name}}"] = np.array(values, dtype=float)
'''


@unittest.skipUnless(shutil.which("mpirun"), "no mpirun")
class TrainStudyTest(ScriptTest):
    def train(self, best, **environment):
        program = self.put("train.py", TRAIN.format(python=sys.executable, best=best))
        os.chmod(program, 0o755)
        done = subprocess.run(["bash", SCRIPT, self.path("out")], capture_output=True, text=True,
                              env={**os.environ, "TRAIN": program, "RANKS": "1", "SLIPSTEP_PYTHON": sys.executable,
                                   **environment})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_all_policies_and_again_when_another_seed_is_better(self):
        text = self.train(best=2)
        self.assertEqual(len(os.listdir(self.path("out/policies"))), 15)
        self.assertEqual(self.content("out/policies/fault_tqc_alpha16.h5"), "16 2")
        self.assertEqual(self.content("out/policies/fault_tqc_alpha8_mesh30.h5"), "8 2 transfer")
        self.assertIn("-train_resume checkpoint_fault_tqc_alpha8_seed2.h5", self.content("out/calls.txt"))
        self.assertEqual(text.count("  taken\n"), 2 * 14)  # as they are chosen, and all together at the end
        calls = self.content("out/calls.txt").count("\n")
        # a training that was killed before it had written its learning curve, and
        os.remove(self.path("out/log_circuit_td3_alpha2_seed1.h5"))
        # one more seed, which is better: alpha 2 and 8 are trained with it, the transfer goes on from it, and nothing
        # is trained twice
        self.train(best=5, MORE_SEEDS="3 5")
        self.assertEqual(self.content("out/calls.txt").count("\n"), calls + 4)
        self.assertEqual(self.content("out/policies/fault_tqc_alpha8_mesh30.h5"), "8 5 transfer")
        self.assertEqual(self.content("out/policies/fault_tqc_alpha1.h5"), "1 2")


if __name__ == "__main__":
    unittest.main()
