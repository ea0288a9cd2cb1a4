"""Another process, in which nothing is imported yet."""

import pickle
import subprocess
import sys

BACK = "import pickle, sys; sys.stdout.buffer.write(pickle.dumps(pickle.load(sys.stdin.buffer)))"


def in_a_new_process(text, sent=b""):
    """What some Python writes that is run in a new process and reads these bytes."""
    done = subprocess.run(
        [sys.executable, "-c", text], input=sent, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def there_and_back(thing):
    """A thing that was sent to a new process, which sent it back."""
    return pickle.loads(in_a_new_process(BACK, pickle.dumps(thing)))
