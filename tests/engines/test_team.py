"""Threads that wait for jobs: who does them, how they end, and that nobody waits for ever."""

import gc
import os
import subprocess
import sys
import threading
import time

import pytest

from glimt.engines.cpu.team import Jobs, Team


def give_all(team, *work):
    jobs = Jobs()
    for number, job in enumerate(work):
        team.give(number, jobs, job)
    return jobs


def test_each_number_is_a_thread_of_its_own_and_stays_it():
    team, seen = Team(), {0: set(), 1: set(), 2: set()}
    for _ in range(5):
        jobs = give_all(team, *(lambda k=k: seen[k].add(threading.get_ident()) for k in seen))
        while not jobs.have_ended(0.1):
            pass
    assert [len(idents) for idents in seen.values()] == [1, 1, 1]
    assert len(set.union(*seen.values(), {threading.get_ident()})) == 4


def test_jobs_under_way_have_not_ended():
    team, go_on = Team(), threading.Event()
    jobs = give_all(team, go_on.wait, lambda: None)
    assert not jobs.have_ended(0.05)
    assert not jobs.have_ended(0.0)
    go_on.set()
    jobs.wait(0.1)
    assert jobs.have_ended(0.0)


def test_no_jobs_have_ended():
    assert Jobs().have_ended(0.0)


def test_a_failed_job_raises_its_error_and_the_others_are_waited_for():
    go_on, done, team = threading.Event(), [], Team()

    def fail():
        raise ZeroDivisionError("of a kernel")

    def work():
        go_on.wait()
        time.sleep(0.05)
        done.append(True)

    jobs = give_all(team, fail, work)
    with pytest.raises(ZeroDivisionError, match="of a kernel"):
        jobs.have_ended(0.1)
    go_on.set()
    jobs.wait(0.01)
    assert done
    assert give_all(team, lambda: None).have_ended(10.0)  # the thread goes on


def test_ctrl_c_that_takes_the_sound_of_the_bell_with_it_hangs_nobody():
    team = Team()
    jobs = give_all(team, lambda: None, lambda: None)
    for _ in range(2):
        jobs._bell.get(timeout=10)
    assert jobs.have_ended(0.01)
    jobs.wait(0.01)


def test_jobs_of_two_callers_are_told_apart():
    team, go_on = Team(), threading.Event()
    held = give_all(team, go_on.wait)
    others = Jobs()
    team.give(1, others, lambda: None)
    assert others.have_ended(10.0)
    assert not held.have_ended(0.0)
    go_on.set()
    assert held.have_ended(10.0)


def test_threads_end_with_their_team():
    team = Team()
    give_all(team, lambda: None, lambda: None).wait(0.1)
    threads = list(team._workers.values())
    assert all(thread.is_alive() for thread in threads)
    del team
    gc.collect()
    assert not any(thread.is_alive() for thread in threads)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork a process")
def test_a_forked_process_starts_threads_of_its_own():
    program = """
import os
from glimt.engines.cpu.team import Jobs, Team

def done(team):
    jobs = Jobs()
    team.give(0, jobs, lambda: None)
    return jobs.have_ended(20.0)

team = Team()
assert done(team)
child = os.fork()
if not child:
    os._exit(0 if done(team) else 1)
print(os.waitpid(child, 0)[1])
"""
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, timeout=60,
                           check=True)
    assert (ended.stdout, ended.stderr) == ("0\n", "")


def test_a_program_that_ends_waits_for_jobs_under_way():
    """A kernel must not run in what is left of an interpreter."""
    program = """
import time
from glimt.engines.cpu.team import Jobs, Team
team = Team()
team.give(0, Jobs(), lambda: (time.sleep(0.5), print("done")))
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert (ended.stdout, ended.stderr) == ("done\n", "")
