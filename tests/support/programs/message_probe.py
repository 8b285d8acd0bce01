"""Messages of a known exchange between two ranks, as `messages` counts them; prints them as JSON.

A persistent message of 800 bytes five times, a plain one of 1600 bytes three times, and seven
reductions of 24 bytes.
"""

import json

import numpy as np
from mpi4py import MPI
from workers.messages import sent

comm = MPI.COMM_WORLD
other = 1 - comm.rank
kept, taken = np.ones(100), np.empty(100)
requests = [comm.Send_init(kept, other, 1), comm.Recv_init(taken, other, 1)]
before = sent()
for time in range(5):
    if time < 4:
        MPI.Prequest.Startall(requests)
    else:
        for request in requests:
            request.Start()
    MPI.Request.Waitall(requests)
more, arrived = np.ones(200), np.empty(200)
for _ in range(3):
    request = comm.Isend(more, other, 2)
    comm.Recv(arrived, other, 2)
    request.Wait()
for _ in range(7):
    comm.Allreduce(np.ones(3), np.empty(3))
found = comm.gather((sent() - before).tolist())
if comm.rank == 0:
    print(json.dumps(found))
