# Fills a template of the manual page or of the completion with what `clustermcml --help` says, so that neither can say
# anything else: awk -v version=V -v date=D -v datadir=DIR -f help.awk HELP TEMPLATE
# A line of the template that is one of the keys of `block` gives way to that block; @VERSION@, @DATE@ and @DATADIR@ to
# the values.
# SPDX-License-Identifier: MIT

# Text of the manual page: the characters that roff would read as its own, and `words` in bold.
function roff(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/\^/, "\\(ha", text)
    gsub(/~/, "\\(ti", text)
    while (match(text, /`[^`]*`/))
        text = substr(text, 1, RSTART - 1) "\\fB" substr(text, RSTART + 1, RLENGTH - 2) "\\fR" substr(text, RSTART + RLENGTH)
    return text ~ /^[.']/ ? "\\&" text : text
}

# The same, in lines of at most 80 bytes.
function prose(text,    count, words, i, line, lines) {
    count = split(text, words, " ")
    line = words[1]
    for (i = 2; i <= count; i++)
        if (length(roff(line " " words[i])) <= 80) line = line " " words[i]
        else {
            lines = lines roff(line) "\n"
            line = words[i]
        }
    return lines roff(line)
}

# What is typed as it stands in bold, what the user fills in in italics, brackets and dots as they are.
function typed(text, fixed,    count, words, i, word, line) {
    count = split(text, words, " ")
    for (i = 1; i <= count; i++) {
        word = roff(words[i])
        if (match(word, /[^][]+/) && word !~ /^\[?\.\.\.\]?,?$/)
            word = substr(word, 1, RSTART - 1) (i <= fixed || words[i] ~ /^\[?-/ ? "\\fB" : "\\fI") \
                   substr(word, RSTART, RLENGTH) "\\fR" substr(word, RSTART + RLENGTH)
        line = line (i > 1 ? " " : "") word
    }
    return line
}

function add(key, line) {
    block[key] = block[key] line "\n"
}

# Two or more spaces stand between what is typed and what it does.
function halves(line) {
    sub(/^ +/, "", line)
    left = line
    right = ""
    if (match(line, /  +/)) {
        left = substr(line, 1, RSTART - 1)
        right = substr(line, RSTART + RLENGTH)
    }
}

function usage(line,    words) {
    halves(line)
    split(left, words, " ")
    fixed = words[2] ~ /^\[?[a-z]+\]?$/ ? 2 : 1
    add("@SYNOPSIS@", (usages++ ? ".br\n" : "") typed(left, fixed))
    add("@COMMANDS@", ".TP\n" typed(left, fixed) "\n" prose(right))
    gsub(/[][]/, "", words[2])
    if (!seen[words[2]]++) add("@COMMAND_WORDS@", words[2])
}

# The option whose lines have been read: to the manual page, and to the completion with the words that it takes.
function end_option(    count, parts, i, list, name) {
    if (option == "") return
    add("@OPTIONS@", ".TP\n" typed(option, 0) (text == "" ? "" : "\n" prose(text)))
    count = split(option, parts, /[ ,]+/)
    for (i = 1; i <= count; i++)
        if (parts[i] ~ /^-/) {
            add("@OPTION_WORDS@", parts[i])
            name = name (name == "" ? "" : "|") parts[i]
        }
    if (parts[count] !~ /^-/) {
        if (parts[count] ~ /^(KIND|NAME)$/) list = choices(text)
        add("@VALUES@", "    " name ") takes_value=1 words=\"" list "\" ;;")
    }
    option = text = ""
}

# "auto (default), plane, cone or mesh" gives auto plane cone mesh.
function choices(text,    count, parts, i, list) {
    gsub(/ *\([^)]*\)/, "", text)
    sub(/^.*: /, "", text)
    count = split(text, parts, /, or |, | or /)
    for (i = 1; i <= count; i++)
        if (parts[i] ~ /^[A-Za-z]+$/) list = list (list == "" ? "" : " ") parts[i]
    return list
}

# "exit codes: 0 ok, 1 results differ, ..., 75 ...": a code begins behind a comma.
function end_codes(    place) {
    sub(/^exit codes: */, "", codes)
    while (codes != "") {
        place = match(codes, /, [0-9]+ /) ? RSTART : length(codes) + 1
        left = substr(codes, 1, place - 1)
        codes = substr(codes, place + 2)
        add("@EXIT_CODES@", ".TP\n.B " (left + 0) "\n" prose(substr(left, index(left, " ") + 1)))
    }
}

FNR == 1 { file++ }

file == 1 && /^usage: / { part = "usage"; sub(/^usage: /, "") }
file == 1 && /^[a-z]+$/ {
    end_option()
    part = $0 == "examples" ? "examples" : "options"
    if (part == "options") add("@OPTIONS@", ".SS " toupper(substr($0, 1, 1)) substr($0, 2))
    next
}
file == 1 && /^exit codes: / { end_option(); part = "codes" }
file == 1 && /^$/ { next }
file == 1 && part == "usage" { usage($0) }
file == 1 && part == "options" && /^  -/ { end_option(); halves($0); option = left; text = right }
file == 1 && part == "options" && /^    / { sub(/^ +/, ""); text = text " " $0 }
file == 1 && part == "codes" { sub(/^ +/, " "); codes = codes $0 }
file == 1 && part == "examples" { sub(/^ +/, ""); add("@EXAMPLES@", roff($0)) }

file == 2 && FNR == 1 { end_codes() }
file == 2 && ($0 in block) { printf "%s", block[$0]; next }
file == 2 {
    gsub(/@VERSION@/, version)
    gsub(/@DATE@/, date)
    gsub(/@DATADIR@/, datadir)
    if (/^@[A-Z_]+@$/) { print "no block " $0 >"/dev/stderr"; exit 1 }
    print
}
