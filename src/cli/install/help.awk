# Fills the template of the manual page, or of the completion, with the text of `clustermcml help`, so that all three
# agree: awk -v version=V -v date=D -v datadir=DIR -f help.awk HELP TEMPLATE
# HELP is the file that help.cmake writes. A line of the template that is a key of `block` is replaced by that block;
# @VERSION@, @DATE@ and @DATADIR@ are replaced by the values.
# SPDX-License-Identifier: MIT

# Returns text for roff: its special characters are escaped, `words` and **words** are bold.
function roff(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/\^/, "\\(ha", text)
    gsub(/~/, "\\(ti", text)
    while (match(text, /`[^`]*`/)) text = bold(text, 1)
    while (match(text, /\*\*[^*]*\*\*/)) text = bold(text, 2)
    return text
}

# Returns the text that match found, without its marks.
function bold(text, marks) {
    return substr(text, 1, RSTART - 1) "\\fB" substr(text, RSTART + marks, RLENGTH - 2 * marks) "\\fR" \
           substr(text, RSTART + RLENGTH)
}

# Escapes a line that roff would read as a request.
function guarded(line) {
    return line ~ /^[.']/ ? "\\&" line : line
}

# Adds running text, in lines of at most 80 bytes.
function prose(text,    count, words, i, line, lines) {
    count = split(roff(text), words, " ")
    line = words[1]
    for (i = 2; i <= count; i++)
        if (length(line " " words[i]) <= 80) line = line " " words[i]
        else {
            lines = lines guarded(line) "\n"
            line = words[i]
        }
    return lines guarded(line)
}

# Marks up a command line: literal words bold, words that the user replaces in italics, brackets and dots plain.
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

# ---- lists of items: the words to type, two or more spaces, the description; further lines are indented ----

function item(line) {
    end_item()
    sub(/^ +/, "", line)
    left = line
    right = ""
    if (match(line, /  +/)) {
        left = substr(line, 1, RSTART - 1)
        right = substr(line, RSTART + RLENGTH)
    }
}

# Returns the pages of a folder; a page beside the folders has a title with a capital letter instead.
function pages(text) {
    gsub(/, /, " ", text)
    return text ~ /[A-Z]/ ? "" : " " text
}

function end_item() {
    if (left != "") {
        if (section == "@list" && part == "exit codes") add("@EXIT_CODES@", ".TP\n.B " left "\n" prose(right))
        if (section == "@list" && part == "topics of help" && left !~ /[A-Z]/) topics = topics " " left
        if (section == "@list" && part == "pages of the manual") topics = topics " " left pages(right)
        if (section == "@command" && part == "examples") add("@EXAMPLES@", roff(left))
        if (section == "@command" && part != "examples") own = own " " names(left, " ")
        if (section == "@options") option()
    }
    left = right = ""
}

# Finds the options of an item: "-o, --output-dir DIR" gives -o and --output-dir.
function names(text, between,    count, parts, i, list) {
    count = split(text, parts, /[ ,]+/)
    for (i = 1; i <= count; i++)
        if (parts[i] ~ /^-/) list = list (list == "" ? "" : between) parts[i]
    return list
}

# Adds an option to the manual page and, with the words that it takes, to the completion.
function option(    count, parts, list) {
    add("@OPTIONS@", ".TP\n" typed(left, 0) "\n" prose(right))
    count = split(left, parts, " ")
    if (parts[count] ~ /^-/) return
    if (parts[count] ~ /^(KIND|NAME)$/) list = choices(right)
    add("@VALUES@", "    " names(left, "|") ") takes_value=1 words=\"" list "\" ;;")
}

# Finds the words that an option takes: "auto (default), plane, cone or mesh" gives auto plane cone mesh.
function choices(text,    count, parts, i, list) {
    gsub(/ *\([^)]*\)/, "", text)
    sub(/^.*: /, "", text)
    count = split(text, parts, /, or |, | or /)
    for (i = 1; i <= count; i++)
        if (parts[i] ~ /^[A-Za-z]+$/) list = list (list == "" ? "" : " ") parts[i]
    return list
}

# ---- a command: its usage, a paragraph, its options ----

function usage(line) {
    sub(/^usage: /, "", line)
    add("@SYNOPSIS@", (usages++ ? ".br\n" : "") typed(line, 2))
    add("@COMMANDS@", ".TP\n" typed(line, 2))
    add("@COMMAND_WORDS@", name)
}

function end_command() {
    if (own == "") return
    add("@OPTIONS_BY_COMMAND@", "    " name ") options=\"" substr(own, 2) "\" ;;")
    own = ""
}

FNR == 1 { file++ }

file == 1 && /^@/ {
    end_item()
    end_command()
    section = $1
    name = $2
    part = ""
    next
}
file == 1 && /^usage: / { if (section == "@command") usage($0); next }
file == 1 && /^$/ { end_item(); next }
file == 1 && /^[a-z ]+$/ && !/^ / {
    part = $0
    if (section == "@options") add("@OPTIONS@", ".SS " toupper(substr($0, 1, 1)) substr($0, 2))
    next
}
file == 1 && /^   / { right = right " " $0; gsub(/  +/, " ", right); next }
file == 1 && /^  / { item($0); next }
file == 1 && section == "@command" && part == "" { add("@COMMANDS@", prose($0)); next }

file == 2 && FNR == 1 {
    end_item()
    end_command()
    add("@TOPICS@", substr(topics, 2))
}
file == 2 && ($0 in block) { printf "%s", block[$0]; next }
file == 2 {
    gsub(/@VERSION@/, version)
    gsub(/@DATE@/, date)
    gsub(/@DATADIR@/, datadir)
    if (/^@[A-Z_]+@$/) { print "no block " $0 >"/dev/stderr"; exit 1 }
    print
}
