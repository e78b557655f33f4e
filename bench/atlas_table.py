"""The atlas as a table: atlas_table.py FILE.csv [--natural]. One row per situation and aim, one column per method; of
natural flights one row per method, and what was found."""
import csv
import sys

EVENTS = ("lost", "wrong", "missed", "spurious", "nan")
METHODS = ("reference-cone", "cpu-cone", "reference-mesh", "cpu-mesh")
SAME = {"reference": "reference-cone", "cpu": "cpu-cone"}  # planes stand in the columns of the cones


def rate(events, crossings):
    """Per 1e8 crossings; after no event at all the bound that 95 % of such flights would keep (rule of three)."""
    return f"{events * 1e8 / crossings:.3g}" if events else f"<{3e8 / crossings:.2g}"


def cell_text(cell):
    if cell is None:
        return "-"
    if cell["status"] != "flown":
        return cell["status"]
    crossings = int(cell["crossings"] or 0)
    if crossings == 0:
        return "no crossing"
    found = [f"{key} {rate(int(cell[key]), crossings)}" for key in EVENTS if int(cell[key] or 0)]
    return ", ".join(found) or rate(0, crossings)


def count(cells, key):
    return sum(int(cell[key] or 0) for cell in cells)


def natural_flights(cells):
    found = {key: count(cells, key) for key in EVENTS}
    print(f"{count(cells, 'crossings'):.3g} crossings of packets aimed at nothing in particular: lost {found['lost']}, "
          f"on the wrong side {found['wrong'] + found['missed']}. The program's own flights are asked only for lost.\n")
    print("| method | situations | crossings | " + " | ".join(EVENTS) + " |")
    print("|---|---|---|" + "---|" * len(EVENTS))
    for method in dict.fromkeys(cell["method"] for cell in cells):
        row = [cell for cell in cells if cell["method"] == method and cell["status"] == "flown"]
        events = " | ".join("-" if method == "program" and key != "lost" else str(count(row, key)) for key in EVENTS)
        print(f"| {method} | {len(row)} | {count(row, 'crossings'):.3g} | {events} |")
    for cell in cells:
        events = ", ".join(f"{key} {cell[key]}" for key in EVENTS if int(cell[key] or 0))
        if events or cell["status"] != "flown":
            print(f"\n{cell['situation']}, {cell['method']}: {cell['status']}, {cell['crossings']} crossings, {events}")


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        cells = list(csv.DictReader(file))
    if "--natural" in sys.argv[2:]:
        natural_flights(cells)
        return
    rows, programs = {}, {}
    for cell in cells:
        if cell["method"] == "program":
            programs[cell["situation"]] = cell
        else:
            rows.setdefault((cell["situation"], cell["aim"]), {})[SAME.get(cell["method"], cell["method"])] = cell
    flown = sum(int(cell["crossings"] or 0) for cell in cells)
    natural = [cell for cell in cells if cell["aim"] == "face" and cell["status"] == "flown"]
    lost = sum(int(cell["lost"]) + int(cell["wrong"]) for cell in natural)
    print(f"{flown:.3g} crossings; lost or on the wrong side in the {sum(int(c['crossings']) for c in natural):.3g} "
          f"of packets aimed at nothing in particular (`face`): {lost}.\n")
    print("Events per 1e8 crossings; `<`: none was seen, and the limit at 95 %. tests/stability/README.md has the words.\n")
    print("| situation | aim | reference, cone | cpu, cone | reference, mesh | cpu, mesh | program |")
    print("|---|---|---|---|---|---|---|")
    named = set()
    for (situation, aim), row in rows.items():
        program = programs.get(situation)
        text = "" if situation in named or program is None else (
            f"lost {program['lost']}, trapped {program['trapped']}, {program['note']}"
            if program["status"] == "flown" else f"{program['status']}: {program['note']}")
        named.add(situation)
        print(f"| {situation} | {aim} | " + " | ".join(cell_text(row.get(m)) for m in METHODS) + f" | {text} |")
    for situation, program in programs.items():
        if situation not in named:
            note = program["note"].split("/")[-1]
            print(f"| {situation} | check | - | - | - | - | {program['status']}: {note} |")


main()
