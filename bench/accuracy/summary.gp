# Three panels, one below the other, from summary.py: bias of Rd over core seconds to a standard error of 0.1 %. Called by it
# with work (a folder of series) and out. To be read at half the width of a page, hence few marks and large letters.
# SPDX-License-Identifier: MIT
scenes = system('cat ' . work . '/scenes')
width = 560.
head = 78.
panel = 206.
gap = 34.
foot = 62.
height = head + 3 * panel + 2 * gap + foot
set terminal svg size width, height font 'sans,14' background '#ffffff'
set output out
set multiplot
set border 3
set tics nomirror
unset mxtics
unset mytics
set logscale xy
set xrange [0.03:30]
set yrange [1e-10:2]
set format y '10^{%T}'
set ytics 1e-9, 1000, 1
set grid lc rgb '#eeeeee' lt 1
set key off
known(scene) = system('cat ' . work . '/' . scene . '.known') + 0.
title_of(scene) = system('cat ' . work . '/' . scene . '.title')
set label 1 'How wrong the reflectance stays, and how long it takes' at screen 0.02, screen 1 - 20 / height font ',17'
set label 2 'up: wrong share of Rd, however many photons fly; arrow: at most so much' at screen 0.02, screen 1 - 42 / height font ',13'
set label 3 'right: seconds of a core to 0.1 % noise; grey: no other program sees it' at screen 0.02, screen 1 - 59 / height font ',13'
do for [i = 1:words(scenes)] {
    scene = word(scenes, i)
    top = 1 - (head + 18 + (i - 1) * (panel + gap)) / height
    set tmargin at screen top
    set bmargin at screen top - (panel - 18) / height
    set lmargin at screen 78 / width
    set rmargin at screen (width - 14) / width
    set label 4 title_of(scene) at graph 0, 1 left offset 0, 0.6
    set label 5 'wrong share of Rd' at screen 16 / width, screen top - (panel - 18) / height / 2 center rotate
    if (i == words(scenes)) {
        set format x '%g'
        set label 6 'seconds of one core until the noise of Rd is 0.1 %' at screen 0.55, screen 18 / height center
    } else {
        set format x ''
    }
    set object 1 rectangle from 0.03, 1e-10 to 30, known(scene) behind fc rgb '#f0f0f0' fs solid noborder
    old = system('cat ' . work . '/' . scene . '.2019') + 0.
    if (old > 0) {
        set arrow 1 from 0.03, old to 30, old nohead dt 2 lw 1.3 lc rgb '#D55E00'
        set label 7 'the program of 2019, as published' at 29, old right offset 0, 0.55 font ',13'
    }
    file = work . '/' . scene
    plot file using ($4 == 0 ? $1 : NaN):2 with points pt 7 ps 0.9 lc rgb '#0072B2', \
        file using ($4 == 1 ? $1 : NaN):2 with points pt 5 ps 0.9 lc rgb '#D55E00', \
        file using ($3 == 1 ? $1 : NaN):2:(0):($2 * 0.06 - $2) with vectors head filled size screen 0.012, 22 lw 1.3 lc rgb '#404040', \
        file using ($7 > 0 ? $1 : NaN):($2 * $6):5 with labels left offset 0.9, 0 font ',13', \
        file using ($7 < 0 ? $1 : NaN):($2 * $6):5 with labels right offset -0.9, 0 font ',13'
    unset label
    unset arrow
    unset object 1
}
unset multiplot
