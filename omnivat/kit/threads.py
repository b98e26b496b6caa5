"""Limit the threads of torch and BLAS for small jobs. Outside `omnivat.fractional`, only this file
sets torch's.

`torch.set_num_threads` changes the calling thread, and also the default of threads started later. A
thread started during a small job would then keep one torch thread for ever, so a helper thread
resets the default at once.
"""

import functools
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context, parent_process
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeVar

import torch

A = TypeVar("A")
B = TypeVar("B")
LIGHT = 128  # widths up to this train faster on one thread
FEW_PAIRS = 4  # up to this many pairs are predicted faster on one thread

_wanted: SimpleQueue[int] = SimpleQueue()  # defaults for threads started later
_keeper: list[threading.Thread] = []
_pinned = threading.local()


@contextmanager
def one_thread(few: bool = True) -> Iterator[None]:
    """Limit torch to one thread inside if there is little work; only in the calling thread."""
    before = torch.get_num_threads()
    if not few or before == 1:
        yield
        return
    torch.set_num_threads(1)
    _start_others_with(before)
    try:
        yield
    finally:
        if not getattr(_pinned, "yes", False):
            torch.set_num_threads(before)


def pin_thread() -> None:
    """Limit the calling thread, a worker, to one torch thread permanently."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    _pinned.yes = True
    if threading.current_thread() is not threading.main_thread():
        _start_others_with(before)


class _Blas:
    """How many threads numpy's BLAS may use: one while anyone needs that, else as many as
    before.
    """

    lock = threading.Lock()
    users = 0
    limit: Any = None

    @classmethod
    def forget(cls) -> None:
        """Reset after a fork: the lock may be held."""
        cls.lock, cls.users = threading.Lock(), 0


@functools.cache
def _blas_controller() -> Any:
    import_module("scipy.linalg")  # load the library first: only a loaded one can be limited
    return import_module("threadpoolctl").ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit numpy's BLAS to one thread: a second one spins, and costs most beside other work.

    The limit applies to the whole process until the last of its users ends.
    """
    with _Blas.lock:
        if not _Blas.users:
            _Blas.limit = _blas_controller().limit(limits=1, user_api="blas")
        _Blas.users += 1
    try:
        yield
    finally:
        with _Blas.lock:
            _Blas.users -= 1
            if not _Blas.users:
                _Blas.limit.restore_original_limits()


def _start_others_with(count: int) -> None:
    if not _keeper or not _keeper[0].is_alive():
        _keeper[:] = [threading.Thread(target=_keep, name="torch threads", daemon=True)]
        _keeper[0].start()
    _wanted.put(count)


def _keep() -> None:
    while True:
        torch.set_num_threads(_wanted.get())


if hasattr(os, "register_at_fork"):  # a forked child has no helper thread yet
    os.register_at_fork(after_in_child=_keeper.clear)
    os.register_at_fork(after_in_child=_Blas.forget)


def in_processes(
    work: Callable[[A], B],
    items: Iterable[A],
    count: int,
    prepare: Callable[..., None] | None = None,
    *arguments: Any,
) -> Iterator[B]:
    """Yield `work(item)` of each item when it is done, from `count` fresh processes.

    prepare  called once in each process, with `arguments`

    Processes end with their parent. Otherwise, those of a killed process would wait for ever and
    keep their memory.
    """
    pool = ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=_begin, initargs=(prepare, arguments)
    )
    try:
        for done in as_completed([pool.submit(work, item) for item in items]):
            yield done.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(prepare: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    Thread(target=_end_with_parent, name="parent", daemon=True).start()
    if prepare is not None:
        prepare(*arguments)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
