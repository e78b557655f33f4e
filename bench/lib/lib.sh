# What the scripts of bench share: options, and one line to standard error with exit code 2 for whatever is wrong before
# anything is measured. Source it as `. "$(dirname "$0")/../lib/lib.sh"`. Sets `here` (the script's folder), `lib`, `root`, and the defaults of
# --program, --build and --out.
# SPDX-License-Identifier: MIT
here=$(cd "$(dirname "$0")" && pwd)
lib=$(cd "$here/../lib" && pwd)
root=$(cd "$here/../.." && pwd)
program=$root/build/clustermcml build=$root/build out=$root/bench/out

fail() { # TEXT
    echo "$(basename "$0"): $1" >&2
    exit 2
}

# Reads the arguments of the script. Every option sets the variable of its name: a flag --quick to "--quick", others to
# their value. --help prints the comment at the script's head.
options() { # "FLAGS" "OPTIONS WITH A VALUE" ARGUMENTS...
    flags=" $1 " valued=" $2 "
    shift 2
    while [ $# -gt 0 ]; do
        case $1 in
        -h | --help) sed -n '2,/^# SPDX/ { /^# SPDX/ !s/^# //p; }' "$0" && exit ;;
        --*) name=${1#--} ;;
        *) fail "$1: not an option (--help lists them)" ;;
        esac
        case $flags$valued in *" $name "*) ;; *) fail "unknown option $1 (--help lists them)" ;; esac
        case $flags in
        *" $name "*) eval "$name=--$name" ;;
        *)
            [ "${2-}" ] || fail "$1 needs a value"
            eval "$name=\$2"
            shift
            ;;
        esac
        shift
    done
}

# The value of an option that counts or measures, like 7, 0.5 or 1e7.
need_number() { # OPTION VALUE
    awk -v x="$2" 'BEGIN { exit x !~ /^[0-9]*\.?[0-9]+([eE][+]?[0-9]+)?$/ || x <= 0 }' || fail "$1 $2: not a number above 0"
}

need() { # COMMAND...
    for wanted; do
        command -v "$wanted" >/dev/null || fail "$wanted is missing"
    done
}

need_built() { # PROGRAM...
    for wanted; do
        [ -f "$wanted" ] && [ -x "$wanted" ] || fail "$wanted is no program: build it first (see README.md)"
    done
}

# The program to be measured, from wherever the script goes later.
need_program() {
    need_built "$program"
    case $program in /*) ;; *) program=$PWD/$program ;; esac
}

# A script with a chart defines `draw CSV TARGET`, which may write into the folder $work, and calls draw_again and draw_result.
draw_in_folder() { # CSV TARGET
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    draw "$1" "$2"
}

# Where the first argument is --draw: draws a result again, and ends the script.
draw_again() { # "WHAT THE TARGET IS" ARGUMENTS...
    [ "${2-}" = --draw ] || return 0
    [ $# -eq 4 ] || fail "--draw needs CSV and $1"
    need python3 gnuplot
    [ -r "$3" ] || fail "$3: cannot be read"
    draw_in_folder "$3" "$4"
    exit
}

# Of a result in the folder of results, where gnuplot is installed.
draw_result() { # CSV TARGET
    if command -v gnuplot >/dev/null; then
        draw_in_folder "$1" "$2"
    else
        echo "no gnuplot, no figure" >&2
    fi
}
