"""Whose turn it is when the maps of several heads or sets are wanted."""

from threading import Event, Thread

from app.frames_job import Turns


def test_a_first_look_goes_before_the_rest_of_a_last_touch():
    turns, order, looked = Turns(), [], Event()

    def first_look():
        turns.take(first_look=True)
        order.append("first look")
        turns.end()
        looked.set()

    turns.take(first_look=False)
    other = Thread(target=first_look)
    other.start()
    while not looked.wait(0.01):
        turns.give_way()  # as between two stops of a map
    order.append("last touch goes on")
    turns.end()
    other.join()
    assert order == ["first look", "last touch goes on"]


def test_nobody_waits_for_a_turn_that_is_free():
    turns = Turns()
    for first_look in (True, False, True):
        turns.take(first_look=first_look)
        turns.give_way()
        turns.end()


def test_two_never_work_at_once():
    turns, inside, most = Turns(), [], []

    def work(first_look):
        for _ in range(50):
            turns.take(first_look=first_look)
            inside.append(1)
            most.append(len(inside))
            if not first_look:
                inside.pop()
                turns.give_way()
                inside.append(1)
                most.append(len(inside))
            inside.pop()
            turns.end()

    threads = [Thread(target=work, args=(first,)) for first in (True, False, False, True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1
