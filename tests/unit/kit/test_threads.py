"""Limits on torch's threads concern the thread that sets them; all limits end with their block."""

import threading
import time

import pytest
import threadpoolctl
import torch

from omnivat.kit.threads import one_blas_thread, one_thread, pin_thread

pytestmark = pytest.mark.usefixtures("two_threads")


def seen_by_a_new_thread():
    """Return how many threads of torch a thread that is born now gets."""
    seen = []
    born = threading.Thread(target=lambda: seen.append(torch.get_num_threads()))
    born.start()
    born.join()
    return seen[0]


def test_little_work_gets_one_thread_and_the_number_returns_after_it():
    with one_thread():
        assert torch.get_num_threads() == 1
    assert torch.get_num_threads() == 2


def test_blas_has_one_thread_until_the_last_of_two_users_ends():
    def counts():
        with one_blas_thread():  # the library is loaded then
            pass
        return {
            i["num_threads"] for i in threadpoolctl.threadpool_info() if i["user_api"] == "blas"
        }

    before, first, second = counts(), one_blas_thread(), one_blas_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert counts() == {1}
    second.__exit__(None, None, None)
    assert counts() == before


def test_much_work_keeps_all_threads():
    with one_thread(False):
        assert torch.get_num_threads() == 2


def test_a_thread_born_inside_anothers_block_gets_all_threads():
    with one_thread():
        deadline = time.monotonic() + 60
        while seen_by_a_new_thread() != 2:
            assert time.monotonic() < deadline
        assert torch.get_num_threads() == 1


def test_a_pinned_thread_stays_at_one_and_others_do_not():
    seen = []

    def work():
        pin_thread()
        with one_thread():
            pass
        seen.append(torch.get_num_threads())

    worker = threading.Thread(target=work)
    worker.start()
    worker.join()
    assert seen == [1]
    deadline = time.monotonic() + 60
    while seen_by_a_new_thread() != 2:
        assert time.monotonic() < deadline
