/* Counts what a rank sends, between the program and MPI (its profiling interface): preloaded, it
   sees every call, by whomever. See messages.py. */
#include <mpi.h>

enum { REQUESTS = 1024 };

/* Point-to-point messages and bytes sent; reductions over all ranks and their bytes. */
long long pgimp_sent[4];

static MPI_Request requests[REQUESTS]; /* persistent ones that send */
static long long sizes[REQUESTS];

static long long size_of(int count, MPI_Datatype type) {
    int each;
    PMPI_Type_size(type, &each);
    return (long long)count * each;
}

static void add(int kind, long long bytes) {
    pgimp_sent[kind]++;
    pgimp_sent[kind + 1] += bytes;
}

static void keep(MPI_Request request, long long bytes) {
    for (int i = 0; i < REQUESTS; i++)
        if (!requests[i]) {
            requests[i] = request;
            sizes[i] = bytes;
            return;
        }
    PMPI_Abort(MPI_COMM_WORLD, 1);
}

static void started(MPI_Request request) {
    for (int i = 0; i < REQUESTS; i++)
        if (requests[i] == request) {
            add(0, sizes[i]);
            return;
        }
}

#define DESTINATION const void *buf, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm
#define SEND(name) \
    int MPI_##name(DESTINATION) { \
        add(0, size_of(count, type)); \
        return PMPI_##name(buf, count, type, to, tag, comm); \
    }
#define ISEND(name) \
    int MPI_##name(DESTINATION, MPI_Request *request) { \
        add(0, size_of(count, type)); \
        return PMPI_##name(buf, count, type, to, tag, comm, request); \
    }
#define INIT(name) \
    int MPI_##name(DESTINATION, MPI_Request *request) { \
        int status = PMPI_##name(buf, count, type, to, tag, comm, request); \
        keep(*request, size_of(count, type)); \
        return status; \
    }
SEND(Send) SEND(Ssend) SEND(Rsend) SEND(Bsend)
ISEND(Isend) ISEND(Issend) ISEND(Irsend) ISEND(Ibsend)
INIT(Send_init) INIT(Ssend_init) INIT(Rsend_init) INIT(Bsend_init)

int MPI_Start(MPI_Request *request) {
    started(*request);
    return PMPI_Start(request);
}

int MPI_Startall(int count, MPI_Request all[]) {
    for (int i = 0; i < count; i++) started(all[i]);
    return PMPI_Startall(count, all);
}

int MPI_Request_free(MPI_Request *request) {
    for (int i = 0; i < REQUESTS; i++)
        if (requests[i] == *request) requests[i] = 0;
    return PMPI_Request_free(request);
}

int MPI_Sendrecv(const void *buf, int count, MPI_Datatype type, int to, int tag, void *into, int room, MPI_Datatype kind, int from, int tagged,
                 MPI_Comm comm, MPI_Status *status) {
    add(0, size_of(count, type));
    return PMPI_Sendrecv(buf, count, type, to, tag, into, room, kind, from, tagged, comm, status);
}

int MPI_Allreduce(const void *buf, void *into, int count, MPI_Datatype type, MPI_Op op,
                  MPI_Comm comm) {
    add(2, size_of(count, type));
    return PMPI_Allreduce(buf, into, count, type, op, comm);
}

int MPI_Iallreduce(const void *buf, void *into, int count, MPI_Datatype type, MPI_Op op,
                   MPI_Comm comm, MPI_Request *request) {
    add(2, size_of(count, type));
    return PMPI_Iallreduce(buf, into, count, type, op, comm, request);
}
