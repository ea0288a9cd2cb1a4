"""A person in front of the page, with a mouse, and with a keyboard for text fields."""

import json
import time

import pytest
from tests.apps.lab.browser import awaited

PLACE = """
(() => {
  const { x, y, width, height } = FOUND.getBoundingClientRect(), at = [x + width / 2, y + height / 2];
  return [...at, FOUND.contains(document.elementFromPoint(...at))];
})()
"""


PRESSED = """
window.pressed = 0;
document.addEventListener(
  "mousedown", (event) => { window.pressed = FOUND?.contains(event.target) ? 1 : 0; }, { once: true, capture: true });
"""


class Person:
    """What a mouse does in a tab of a browser, and what can be read there."""

    def __init__(self, tab, downloads):
        self.tab, self.downloads = tab, downloads
        tab.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))
        tab.call("Page.setInterceptFileChooserDialog", enabled=True)

    def waits(self, expression, seconds=60):
        """Wait until an expression holds."""
        until = time.monotonic() + seconds
        while not self.tab.run(f"Boolean({expression})"):
            failed = "'failed'" not in expression and self.tab.run("byId('failed').textContent")
            if failed or time.monotonic() > until:
                message = self.tab.run("[byId('failed').textContent, JSON.stringify(state)]")
                raise AssertionError(f"not within {seconds} s: {expression}; {message}")
            time.sleep(0.05)

    def clicks(self, selector, seconds=60):
        """Press and release the left button in the middle of what a selector finds, once it is there and enabled.

        A page that still changes may move it away from under the mouse: then a person presses again.
        """
        result = f"document.querySelector({json.dumps(selector)})"
        self.waits(f"{result} && !{result}.disabled && {result}.getClientRects().length", seconds)
        for _ in range(5):
            self.tab.run(PRESSED.replace("FOUND", result))
            self.tab.run(f"{result}.scrollIntoView({{ block: 'center' }})")
            x, y, under = self.tab.run(PLACE.replace("FOUND", result))
            assert under, f"{selector} lies under something else"
            self.tab.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
            for kind in ("mousePressed", "mouseReleased"):
                self.tab.call(
                    "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1
                )
            if self.tab.run("window.pressed !== 0"):
                return
        raise AssertionError(f"{selector} moves away from under the mouse")

    def chooses(self, *files):
        """Click on the field for files, and choose some in the dialogue that opens."""
        count = self.tab.run("state.files.length + (state.axis.text ? 1 : 0)")
        begun = len(self.tab.events)
        self.clicks("#drop")
        opened = next(
            (
                e["params"]
                for e in self.tab.events[begun:]
                if e.get("method") == "Page.fileChooserOpened"
            ),
            None,
        )
        opened = opened or self.tab.wait_for("Page.fileChooserOpened")
        self.tab.call(
            "DOM.setFileInputFiles",
            files=[str(file) for file in files],
            backendNodeId=opened["backendNodeId"],
        )
        self.waits(f"state.files.length + (state.axis.text ? 1 : 0) > {count}")

    def types(self, name, text):
        """Click into a field, replace its text and leave it."""
        field = f'[name="{name}"]'
        self.clicks(field)
        self.tab.run(f"document.querySelector({json.dumps(field)}).select()")
        self.tab.call("Input.insertText", text=text)
        for kind in ("rawKeyDown", "keyUp"):
            self.tab.call(
                "Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9
            )

    def selects(self, name, option):
        """Select an option by typing its name."""
        field = f'[name="{name}"]'
        self.clicks(field)
        self.tab.run(f"document.querySelector({json.dumps(field)}).focus()")
        for letter in option:
            self.tab.call("Input.dispatchKeyEvent", type="keyDown", key=letter, text=letter)
        self.tab.call(
            "Input.dispatchKeyEvent",
            type="keyDown",
            key="Enter",
            code="Enter",
            windowsVirtualKeyCode=13,
            text="\r",
        )
        self.waits(f"document.querySelector({json.dumps(field)}).value === {json.dumps(option)}")

    def ticks(self, name, *values):
        """Tick these boxes of a name, and no others."""
        for value, now in self.tab.run(
            f"[...document.getElementsByName('{name}')].map((box) => [box.value, box.checked])"
        ):
            if now != (value in values):
                box = f'input[name="{name}"][value="{value}"]'
                self.clicks(box)
                self.waits(
                    f"document.querySelector({json.dumps(box)}).checked === {json.dumps(value in values)}"
                )

    def loads(self, selector, name):
        """Click, and return the file that is downloaded."""
        self.clicks(selector)
        file = self.downloads / name
        awaited(file.exists, 30.0, self.downloads)
        time.sleep(0.2)
        return file

    def identifies(self, *models, by_direction=False, seconds=240):
        """Go from the columns to the verdict, with these models, or else with the models that the page proposes."""
        self.waits("!byId('step-2').classList.contains('locked')")
        self.clicks("#check-now")
        self.waits("!byId('step-4').classList.contains('locked')")
        if models:
            self.ticks("model", *models)
        if by_direction:
            self.clicks("#asymmetry")
        self.clicks("#identify")
        self.waits(
            "state.parts.identified && !state.parts.identified.old && state.job.state === 'done'",
            seconds,
        )
        self.waits("byId('ruling') && !byId('step-6').classList.contains('locked')")


@pytest.fixture
def person_at(shown, tmp_path):
    """A function that gives a person in front of the page of a server."""

    def sit(server, **how):
        person = Person(shown(server.address, **how), tmp_path)
        person.waits("state")
        return person

    return sit
