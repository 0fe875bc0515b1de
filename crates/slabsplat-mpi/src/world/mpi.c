/* The few functions of MPI that slabsplat calls, without MPI's types, which differ from one MPI to the next: a
 * communicator is the number that it has in Fortran, a request a pointer. All return MPI's codes, 0 if all is
 * well, and none blocks but the first, the last, `slabsplat_mpi_dup` and `slabsplat_mpi_first_here`. */

#include <mpi.h>
#include <stdlib.h>

/* Starts MPI, unless the program has done so; `was_started` tells. `comm` is all ranks. */
int slabsplat_mpi_start(int *was_started, int *comm)
{
    int code = MPI_Initialized(was_started);
    if (code == MPI_SUCCESS && !*was_started) {
        int provided;
        /* Only the thread that starts it calls it. */
        code = MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided);
    }
    if (code == MPI_SUCCESS)
        *comm = (int)MPI_Comm_c2f(MPI_COMM_WORLD);
    return code;
}

/* The same ranks with messages of their own. An error is returned then, and ends no program. */
int slabsplat_mpi_dup(int comm, int *own, int *rank, int *n_ranks)
{
    MPI_Comm dup;
    int code = MPI_Comm_dup(MPI_Comm_f2c((MPI_Fint)comm), &dup);
    if (code != MPI_SUCCESS)
        return code;
    *own = (int)MPI_Comm_c2f(dup);
    code = MPI_Comm_set_errhandler(dup, MPI_ERRORS_RETURN);
    if (code == MPI_SUCCESS)
        code = MPI_Comm_rank(dup, rank);
    if (code == MPI_SUCCESS)
        code = MPI_Comm_size(dup, n_ranks);
    return code;
}

/* The first rank, of those in `own`, of this one's computer. */
int slabsplat_mpi_first_here(int own, int *first)
{
    MPI_Comm all = MPI_Comm_f2c((MPI_Fint)own), here;
    int rank;
    int code = MPI_Comm_rank(all, &rank);
    if (code == MPI_SUCCESS)
        code = MPI_Comm_split_type(all, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &here);
    if (code != MPI_SUCCESS)
        return code;
    code = MPI_Allreduce(&rank, first, 1, MPI_INT, MPI_MIN, here);
    int freed = MPI_Comm_free(&here);
    return code == MPI_SUCCESS ? freed : code;
}

int slabsplat_mpi_free(int own)
{
    MPI_Comm comm = MPI_Comm_f2c((MPI_Fint)own);
    return MPI_Comm_free(&comm);
}

/* `bytes` have to stay until the request is done. */
int slabsplat_mpi_send(int own, const void *bytes, int n_bytes, int to, int tag, void **request)
{
    MPI_Request *sent = malloc(sizeof *sent);
    int code = MPI_ERR_NO_MEM;
    if (sent != NULL)
        code = MPI_Isend(bytes, n_bytes, MPI_BYTE, to, tag, MPI_Comm_f2c((MPI_Fint)own), sent);
    if (code != MPI_SUCCESS) {
        free(sent);
        sent = NULL;
    }
    *request = sent;
    return code;
}

/* Whether a request is done, which frees it. */
int slabsplat_mpi_is_done(void *request, int *is_done)
{
    int code = MPI_Test(request, is_done, MPI_STATUS_IGNORE);
    if (code == MPI_SUCCESS && *is_done)
        free(request);
    return code;
}

/* Whether a message is there, and how long it is. */
int slabsplat_mpi_probe(int own, int from, int tag, int *is_there, int *n_bytes)
{
    MPI_Status status;
    int code = MPI_Iprobe(from, tag, MPI_Comm_f2c((MPI_Fint)own), is_there, &status);
    if (code == MPI_SUCCESS && *is_there)
        code = MPI_Get_count(&status, MPI_BYTE, n_bytes);
    return code;
}

/* Takes in a message that is there. */
int slabsplat_mpi_receive(int own, void *bytes, int n_bytes, int from, int tag)
{
    return MPI_Recv(bytes, n_bytes, MPI_BYTE, from, tag, MPI_Comm_f2c((MPI_Fint)own), MPI_STATUS_IGNORE);
}

/* The computer's name; `name` has room for `n_bytes`. */
int slabsplat_mpi_node(char *name, int n_bytes, int *length)
{
    char whole[MPI_MAX_PROCESSOR_NAME];
    int code = MPI_Get_processor_name(whole, length);
    if (code != MPI_SUCCESS)
        return code;
    *length = *length < n_bytes ? *length : n_bytes;
    for (int idx = 0; idx < *length; idx++)
        name[idx] = whole[idx];
    return code;
}

/* What a code means. */
int slabsplat_mpi_text(int code, char *text, int n_bytes, int *length)
{
    char whole[MPI_MAX_ERROR_STRING];
    int failed = MPI_Error_string(code, whole, length);
    if (failed != MPI_SUCCESS)
        return failed;
    *length = *length < n_bytes ? *length : n_bytes;
    for (int idx = 0; idx < *length; idx++)
        text[idx] = whole[idx];
    return failed;
}

/* Ends all ranks. */
int slabsplat_mpi_abort(int own)
{
    return MPI_Abort(MPI_Comm_f2c((MPI_Fint)own), 1);
}

int slabsplat_mpi_end(void)
{
    return MPI_Finalize();
}
