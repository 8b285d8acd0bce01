"""Migration: particles whose layer now belongs to a neighbour move there, with all columns.

Each step one message goes to each neighbour: the number of migrants, and their records up to the
length of the receiver's buffer. The rest follows in a second message, and both sides then enlarge
their buffers alike.
"""

import weakref

import numpy as np

from pgimp.decomposition.population import Population, with_capacity
from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.particles import Columns, Particles
from pgimp.kernels.order.layer_changes import pack_rows, partition_migrants, unpack_rows
from pgimp.mpi.communicator import Communicator, Request

_UP, _DOWN, _REST_UP, _REST_DOWN = 3, 10, 6, 11

#: Records in a message's first buffer.
CAPACITY = 32


def pack(particles: Particles, rows: np.ndarray) -> np.ndarray:
    """All columns of the particles in `rows`, (n, width) int64, bit by bit."""
    wire = np.empty((len(rows), particles.width), np.int64)
    pack_rows(*particles.columns(), rows, wire.reshape(-1), 0, particles.width)
    return wire


def unpack(records: np.ndarray, particles: Particles, rows: np.ndarray) -> None:
    """Set `rows` of the particles from records made by `pack`."""
    unpack_rows(*particles.columns(), rows, records.reshape(-1), 0, particles.width)


def _wire(records: int, columns: int) -> np.ndarray:
    """A message's buffer: the number of particles, and space for `records` records."""
    return np.zeros(1 + records * columns, np.int64)


def _grown(number: int) -> int:
    """Capacity of a new buffer, after one was too small for `number` particles."""
    return number + number // 2


class _Link:
    """The messages between a rank and one of its neighbours.

    Tags differ by direction: on a ring of two ranks both neighbours are one.
    """

    def __init__(self, comm: Communicator, neighbour: int, columns: int, above: bool) -> None:
        self.comm, self.neighbour, self.columns = comm, neighbour, columns
        up, down = (_UP, _REST_UP), (_DOWN, _REST_DOWN)
        self.sends, self.receives = (up, down) if above else (down, up)
        self.to_send, self.to_receive = CAPACITY, CAPACITY  # records in the first message
        self.outgoing, self.incoming = _wire(CAPACITY, columns), _wire(CAPACITY, columns)
        self.receipt = comm.Recv_init(self.incoming, neighbour, self.receives[0])
        self.requests: list[Request] = []

    def send(self, columns: Columns, rows: np.ndarray) -> int:
        """Begin the exchange with `rows` of the particles; returns the number of messages sent."""
        self.receipt.Start()
        number, capacity = len(rows), self.to_send
        if number > capacity:
            self.to_send = _grown(number)
            self.outgoing = _wire(self.to_send, self.columns)
        self.outgoing[0] = number
        if number:
            pack_rows(*columns, rows, self.outgoing, 1, self.columns)
        end = 1 + number * self.columns
        full = 1 + capacity * self.columns
        requests, (first, rest) = self.requests, self.sends
        requests.append(self.comm.Isend(self.outgoing[: min(end, full)], self.neighbour, first))
        if end > full:
            requests.append(self.comm.Isend(self.outgoing[full:end], self.neighbour, rest))
        return len(requests)

    def wait(self) -> int:
        """Wait for the neighbour's particles; returns their number."""
        self.receipt.Wait()
        number = int(self.incoming[0])
        if number > self.to_receive:
            self.to_receive = _grown(number)
            first, self.incoming = self.incoming, _wire(self.to_receive, self.columns)
            self.incoming[: len(first)] = first
            rest = self.incoming[len(first) : 1 + number * self.columns]
            self.comm.Recv(rest, self.neighbour, self.receives[1])
            self.receipt.Free()
            self.receipt = self.comm.Recv_init(self.incoming, self.neighbour, self.receives[0])
        return number

    def end(self) -> None:
        """Wait until all is sent."""
        for request in self.requests:
            request.Wait()
        self.requests.clear()


def _close(links: list[_Link]) -> None:
    for link in links:
        link.receipt.Free()
    links.clear()


class Migration:
    """Migration of particles between a rank and its two neighbours.

    Receives are persistent and buffers are kept. When slabs change, create another on all ranks in
    the same step, and `close` the old one. An open one is closed at the process's end, before MPI.

    Parameters
    ----------
    slab : Slab
        This rank's slab.
    particles : Particles
        This rank's particles; only the columns matter.
    ring : int
        Number of layers of a ring; 0 where they form a line.

    Attributes
    ----------
    messages, bytes : int
        Sent so far by this rank.
    """

    def __init__(self, comm: Communicator, slab: Slab, particles: Particles, ring: int = 0) -> None:
        self.messages = self.bytes = 0
        columns, self._ring = particles.width, ring
        lower, upper = (
            None
            if neighbour is None or neighbour == comm.rank
            else _Link(comm, neighbour, columns, above)
            for neighbour, above in ((slab.lower, False), (slab.upper, True))
        )
        self._lower, self._upper = lower, upper
        self._links = [link for link in (lower, upper) if link is not None]
        self._arrivals, self._migrants = np.empty(0, np.int32), np.empty(0, np.int32)
        self._stay = 0
        self._sent = False
        self.close = weakref.finalize(self, _close, self._links)

    def proceed(self, population: Population, offsets: np.ndarray) -> None:
        """Process particles that have changed their layer; not collective beyond the neighbours.

        At the first call in a step, particles that have left the slab are sent; later calls must
        have none.

        Parameters
        ----------
        population : Population
            This rank's population; it frees the rows of leaving particles.
        offsets : (k,) int32
            Offsets of the particles in its order.
        """
        down = up = 0
        found = len(offsets)
        if found:
            self._arrivals = with_capacity(self._arrivals, self._stay + found, self._stay)
            self._migrants = with_capacity(self._migrants, found)
            layer, order = population.up_to_date().layer, population.order
            slab, kept = (population.first, population.layers), self._arrivals[self._stay :]
            stay, down, up = partition_migrants(
                layer, order, offsets, *slab, self._ring, kept, self._migrants
            )
            self._stay += stay
        if self._sent:
            return
        self._sent = True
        migrants = self._migrants[:down], self._migrants[len(self._migrants) - up :]
        for link, rows in zip((self._lower, self._upper), migrants, strict=True):
            if link is not None:
                self.messages += link.send(population.layout(), rows)
                self.bytes += 8 * (1 + len(rows) * link.columns)
                if len(rows):
                    population.free_later(rows)

    def receive(self, population: Population) -> np.ndarray:
        """Receive the arriving particles, after `proceed`; not collective beyond the neighbours.

        Returns
        -------
        (n,) int32
            Rows of the particles that are new in a layer of this rank, until the next call.
        """
        count, self._stay, self._sent = self._stay, 0, False
        for link in self._links:
            number = link.wait()
            if number:
                self._arrivals = with_capacity(self._arrivals, count + number, count)
                rows = self._arrivals[count : count + number]
                population.insert(number, rows)
                unpack_rows(*population.layout(), rows, link.incoming, 1, link.columns)
                count += number
        for link in self._links:
            link.end()
        return self._arrivals[:count]
