/* Heat that spreads, on all ranks, and a picture of it every few steps while it runs: slabsplat from C.
 * Each rank has a slab along z with a plane of ghosts on either side, in an array with z fastest.
 *
 *     mpirun -n 3 ./heat 32 frames
 */

#include "slabsplat_mpi.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N_FRAMES = 4, STEPS_A_FRAME = 10 };

static const char *const SCENE =
    "[classify]\n"
    "opacity = [[0.02, 0.0], [0.2, 0.05], [0.8, 0.4]]\n"
    "color = [[0.02, 0.1, 0.1, 0.6], [0.2, 0.9, 0.2, 0.1], [0.8, 1.0, 0.9, 0.3]]\n"
    "[camera]\n"
    "eye = [2.1, -1.5, 1.5]\n"
    "target = [0.5, 0.5, 0.5]\n"
    "up = [0.0, 0.0, 1.0]\n"
    "fov_y = 30.0\n"
    "[image]\n"
    "width = 128\n"
    "height = 128\n";

/* Where a voxel is in an array of n * n columns, each `depth` long. */
static size_t at(int i, int j, int k, int n, int depth)
{
    return ((size_t)i * n + j) * depth + k;
}

/* A plane of an array to a neighbour, and the neighbour's into another plane. */
static void swap(double *heat, int n, int depth, int from, int to, int rank_to, int rank_from)
{
    double *sent = calloc((size_t)n * n, sizeof(double)), *received = calloc((size_t)n * n, sizeof(double));
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sent[i * n + j] = heat[at(i, j, from, n, depth)];
    MPI_Sendrecv(sent, n * n, MPI_DOUBLE, rank_to, 0, received, n * n, MPI_DOUBLE, rank_from, 0, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
    for (int i = 0; rank_from != MPI_PROC_NULL && i < n; i++)
        for (int j = 0; j < n; j++)
            heat[at(i, j, to, n, depth)] = received[i * n + j];
    free(sent);
    free(received);
}

static void step(double *heat, double *next, int n, int depth)
{
    memcpy(next, heat, sizeof(double) * n * n * depth);
    for (int i = 1; i + 1 < n; i++)
        for (int j = 1; j + 1 < n; j++)
            for (int k = 1; k + 1 < depth; k++) {
                double around = heat[at(i - 1, j, k, n, depth)] + heat[at(i + 1, j, k, n, depth)] +
                                heat[at(i, j - 1, k, n, depth)] + heat[at(i, j + 1, k, n, depth)] +
                                heat[at(i, j, k - 1, n, depth)] + heat[at(i, j, k + 1, n, depth)];
                double here = heat[at(i, j, k, n, depth)];
                next[at(i, j, k, n, depth)] = here + 0.15 * (around - 6.0 * here);
            }
    memcpy(heat, next, sizeof(double) * n * n * depth);
}

/* Fails on all ranks or on none, and rank 0 says why. */
static int failed(const SlabsplatSimulation *simulation, int rank)
{
    const char *error = slabsplat_simulation_error(simulation);
    if (error != NULL && rank == 0)
        fprintf(stderr, "error: %s\n", error);
    return error != NULL;
}

int main(int argc, char **argv)
{
    int rank, n_ranks, n = argc > 1 ? atoi(argv[1]) : 32;
    const char *folder = argc > 2 ? argv[2] : ".";
    if (n < 8)
        return 2;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);

    int first = rank * n / n_ranks, end = (rank + 1) * n / n_ranks, depth = end - first + 2;
    double *heat = calloc((size_t)n * n * depth, sizeof(double)), *next = calloc((size_t)n * n * depth, sizeof(double));
    int below = rank > 0 ? rank - 1 : MPI_PROC_NULL, above = rank + 1 < n_ranks ? rank + 1 : MPI_PROC_NULL;

    double side = 1.0 / n;
    SlabsplatGrid grid = {{n, n, n}, {side, 0, 0, 0, side, 0, 0, 0, side, 0, 0, 0}};
    SlabsplatBox own = {{0, 0, first}, {n, n, end}};
    SlabsplatSimulation *simulation =
        slabsplat_simulation_new(MPI_Comm_c2f(MPI_COMM_WORLD), &grid, &own, SCENE, 60.0);
    int is_wrong = failed(simulation, rank);

    for (int frame = 0; !is_wrong && frame < N_FRAMES; frame++) {
        for (int idx = 0; idx < STEPS_A_FRAME; idx++) {
            for (int k = 0; k < end - first; k++)
                if (first + k >= n / 3 && first + k < n / 2)
                    heat[at(n / 2, n / 2, k + 1, n, depth)] = heat[at(n / 3, n / 2, k + 1, n, depth)] = 4.0;
            swap(heat, n, depth, 1, depth - 1, below, above);
            swap(heat, n, depth, depth - 2, 0, above, below);
            step(heat, next, n, depth);
        }
        /* What is handed over begins behind the plane of ghosts. */
        SlabsplatField field = {heat + 1, 3, own, {(uint64_t)n * depth, depth, 1}};
        char name[512];
        snprintf(name, sizeof name, "%s/%04d.png", folder, frame);
        slabsplat_simulation_write(simulation, &field, 1, name);
        is_wrong = failed(simulation, rank);
    }

    slabsplat_simulation_free(simulation);
    free(heat);
    free(next);
    MPI_Finalize();
    return is_wrong;
}
