"""Names that people give to columns, models, variants, axes and files, or that files bring along."""

LONG = "axis_of_the_" + "very_" * 60 + "long_machine"

NAMES = (
    "$\\alpha_{1$ \\frac{ %d 100 % ^^ _x_",
    '<script>alert(1)</script> & &amp; ]]> --> " \' d="1.23456" id="x" url(#x)',
    LONG + "_1",
    LONG + "_2",
    "_hidden",
    "",
    " \t ",
    "first\nsecond\r\nthird\x0b\x85\u2028fourth",
    "\x00\x07\x1b[31mred\x7f\x9f \ud800 \udcff \ufffe \uffff \ufdd0 \U0001fffe",
    "ציר ראשי עם שם בעברית",
    "المحور الرئيسي 12",
    "\u202etxet desrever\u202c \u2066isolated",
    "😀 👩‍👩‍👧 轴的名称 축 e\u0301\u0301\u0301 ﷽",
    "{0} {{ x }} {% raw %} %s",
    "nolegend",
    "None",
)
