"""Optuna searches the space of a study: it asks, amacrine tells.

    pip install optuna
    python examples/optuna/search.py studies/formats.toml --trials 20

One amacrine answers all points, a line of JSON each, and keeps what they share. The two
objectives are the error (1 - kept) and a cost; what comes out is their front.
"""

import argparse
import json
import subprocess
import sys

import optuna


def suggest(trial, axis, side):
    """A value of one axis; its name has the side in it, as spaces of sides differ."""
    name = f"{side}.{axis['name']}"
    if "values" in axis:
        # Optuna's categories are plain values: tables go as text.
        return json.loads(trial.suggest_categorical(name, [json.dumps(v) for v in axis["values"]]))
    if axis["whole"]:
        return trial.suggest_int(name, int(axis["from"]), int(axis["to"]))
    return trial.suggest_float(name, axis["from"], axis["to"], log=axis["log"])


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("study")
    arguments.add_argument("--trials", type=int, default=20)
    arguments.add_argument("--cost", default="bits")
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--program", default="amacrine", help="where amacrine is")
    given = arguments.parse_args()

    sweep = [given.program, "sweep", given.study]
    try:
        said = subprocess.run([*sweep, "--space"], stdout=subprocess.PIPE, check=True).stdout
    except OSError as error:
        sys.exit(f"{given.program} cannot be run ({error.strerror}): give --program PATH")
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode)  # amacrine has said why
    space = json.loads(said)
    sides = {str(side["number"]): side for side in space["sides"]}
    server = subprocess.Popen(
        [*sweep, "--tell"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )

    def objective(trial):
        side = sides[trial.suggest_categorical("side", list(sides))]
        point = {"side": side["number"]}
        for axis in side["axes"]:
            if len(axis.get("values", [0, 0])) > 1:
                point[axis["name"]] = suggest(trial, axis, side["number"])
        server.stdin.write(json.dumps(point) + "\n")
        server.stdin.flush()
        row = json.loads(server.stdout.readline())
        if row["outcome"] != "done":
            raise optuna.TrialPruned(row["reason"])
        if row["error"] is None:
            raise optuna.TrialPruned("no event, or chance alone scores 1")
        return row["error"], row[given.cost]

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.NSGAIISampler(population_size=10, seed=given.seed)
    study = optuna.create_study(directions=["minimize", "minimize"], sampler=sampler)
    study.optimize(objective, n_trials=given.trials)
    server.stdin.close()
    server.wait()
    print(f"error    {given.cost}")
    for trial in sorted(study.best_trials, key=lambda trial: trial.values):
        words = [str(value).strip('"') for value in trial.params.values()]
        print(f"{trial.values[0]:.4f}  {trial.values[1]:10.0f}  {' '.join(words)}")


if __name__ == "__main__":
    main()
