/* Factorise and solve a plane system of `fluid-solver` with PARDISO (MKL), MUMPS or UMFPACK, one thread, the analysis
 * kept: medians of the CPU time of each, and how far the solution is from the other one. README.md says how to
 * build it and what the file holds. */
#include <dlfcn.h>
#include <dmumps_c.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/umfpack.h>
#include <time.h>

#define REPEATS 7

struct system {
	int64_t n, entries;
	int *row, *column; /* from 1, row by row */
	double *value, *right, *other;
};

static double now(void)
{
	struct timespec time;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
	return 1e3 * time.tv_sec + 1e-6 * time.tv_nsec;
}

static void *block(FILE *file, size_t size, size_t count)
{
	void *data = malloc(size * count);
	if (!data || fread(data, size, count, file) != count) {
		fprintf(stderr, "the file ends too early, or there is no memory for %zu numbers\n", count);
		exit(2);
	}
	return data;
}

static int ascending(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *values)
{
	qsort(values, REPEATS, sizeof *values, ascending);
	return values[REPEATS / 2];
}

static void check(const char *solver, int fine, long code)
{
	if (!fine) {
		fprintf(stderr, "%s: error %ld\n", solver, code);
		exit(3);
	}
}

/* Compressed rows from 0, each ascending, as PARDISO and (transposed) UMFPACK take them. */
static void compress(const struct system *s, int **start, int **column, double **value)
{
	*start = calloc(s->n + 1, sizeof **start);
	*column = malloc(sizeof **column * s->entries);
	*value = malloc(sizeof **value * s->entries);
	int *end = malloc(sizeof *end * s->n);
	for (int64_t k = 0; k < s->entries; k++)
		(*start)[s->row[k]]++;
	for (int64_t k = 0; k < s->n; k++) {
		end[k] = (*start)[k];
		(*start)[k + 1] += (*start)[k];
	}
	for (int64_t k = 0; k < s->entries; k++) {
		int row = s->row[k] - 1, at = end[row]++, first = (*start)[row];
		for (; at > first && (*column)[at - 1] >= s->column[k]; at--) {
			(*column)[at] = (*column)[at - 1];
			(*value)[at] = (*value)[at - 1];
		}
		(*column)[at] = s->column[k] - 1;
		(*value)[at] = s->value[k];
	}
	free(end);
}

typedef void (*pardiso_t)(void **, const int *, const int *, const int *, const int *, const int *, const void *,
			  const int *, const int *, int *, const int *, int *, const int *, void *, void *, int *);

static void pardiso(const struct system *s, const char *library, int single, double *x, double *factor, double *solve)
{
	void *mkl = dlopen(library, RTLD_NOW | RTLD_GLOBAL);
	if (!mkl) {
		fprintf(stderr, "%s\n", dlerror());
		exit(2);
	}
	pardiso_t call = (pardiso_t)dlsym(mkl, "pardiso");
	int *start, *column;
	double *value;
	compress(s, &start, &column, &value);
	float *values32 = malloc(sizeof *values32 * s->entries), *x32 = malloc(8 * s->n), *b32 = x32 + s->n;
	for (int64_t k = 0; k < s->entries; k++)
		values32[k] = value[k];
	for (int64_t k = 0; k < s->n; k++)
		b32[k] = s->right[k];
	void *handle[64] = {0};
	int options[64] = {0}, one = 1, type = 1 /* real, symmetric structure */, n = s->n, none = 0, error = 0, phase;
	options[0] = 1;
	options[1] = 2;	  /* nested dissection of METIS */
	options[9] = 13;  /* small pivots become 1e-13 */
	options[10] = 1;  /* scaling */
	options[12] = 1;  /* matching */
	options[27] = single;
	options[34] = 1;  /* counts from 0 */
	const void *a = single ? (void *)values32 : (void *)value;
	void *b = single ? (void *)b32 : (void *)s->right, *to = single ? (void *)x32 : (void *)x;
	phase = 11;
	call(handle, &one, &one, &type, &phase, &n, a, start, column, &none, &one, options, &none, b, to, &error);
	check("PARDISO, analysis", error == 0, error);
	for (int k = 0; k < REPEATS; k++) {
		double begin = now();
		phase = 22;
		call(handle, &one, &one, &type, &phase, &n, a, start, column, &none, &one, options, &none, b, to, &error);
		check("PARDISO, factor", error == 0, error);
		factor[k] = now() - begin;
		begin = now();
		phase = 33;
		call(handle, &one, &one, &type, &phase, &n, a, start, column, &none, &one, options, &none, b, to, &error);
		check("PARDISO, solve", error == 0, error);
		solve[k] = now() - begin;
	}
	for (int64_t k = 0; single && k < s->n; k++)
		x[k] = x32[k];
}

static void mumps(const struct system *s, double *x, double *factor, double *solve)
{
	DMUMPS_STRUC_C m;
	memset(&m, 0, sizeof m);
	m.par = 1;
	m.job = -1;
	dmumps_c(&m);
	m.n = s->n;
	m.nnz = s->entries;
	m.irn = s->row;
	m.jcn = s->column;
	m.a = s->value;
	m.rhs = x;
	for (int k = 0; k < 3; k++)
		m.icntl[k] = -1;
	m.icntl[6] = 5;	  /* METIS; AMD and PORD are slower here */
	m.icntl[13] = 60; /* % more memory than foreseen */
	m.job = 1;
	dmumps_c(&m);
	check("MUMPS, analysis", m.infog[0] >= 0, m.infog[0]);
	for (int k = 0; k < REPEATS; k++) {
		double begin = now();
		m.job = 2;
		dmumps_c(&m);
		check("MUMPS, factor", m.infog[0] >= 0, m.infog[0]);
		factor[k] = now() - begin;
		memcpy(x, s->right, sizeof *x * s->n);
		begin = now();
		m.job = 3;
		dmumps_c(&m);
		solve[k] = now() - begin;
	}
}

static void umfpack(const struct system *s, double *x, double *factor, double *solve)
{
	int *start, *column;
	double *value, control[UMFPACK_CONTROL];
	void *symbolic, *numeric;
	compress(s, &start, &column, &value);
	umfpack_di_defaults(control);
	control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC; /* the structure is */
	control[UMFPACK_IRSTEP] = 0;
	long error = umfpack_di_symbolic(s->n, s->n, start, column, value, &symbolic, control, NULL);
	check("UMFPACK, analysis", error == 0, error);
	for (int k = 0; k < REPEATS; k++) {
		double begin = now();
		error = umfpack_di_numeric(start, column, value, symbolic, &numeric, control, NULL);
		check("UMFPACK, factor", error == 0, error);
		factor[k] = now() - begin;
		begin = now();
		umfpack_di_solve(UMFPACK_At, start, column, value, x, s->right, numeric, control, NULL);
		solve[k] = now() - begin;
		umfpack_di_free_numeric(&numeric);
	}
}

int main(int count, char **arguments)
{
	FILE *file = count >= 3 ? fopen(arguments[1], "rb") : NULL;
	if (!file) {
		fprintf(stderr, "usage: peers FILE mumps | umfpack | pardiso LIBRARY | pardiso-single LIBRARY\n");
		return 2;
	}
	int64_t *sizes = block(file, 8, 2);
	struct system s = {.n = sizes[0], .entries = sizes[1]};
	s.row = block(file, 4, s.entries);
	s.column = block(file, 4, s.entries);
	s.value = block(file, 8, s.entries);
	s.right = block(file, 8, s.n);
	s.other = block(file, 8, s.n);
	double *x = calloc(s.n, sizeof *x), factor[REPEATS], solve[REPEATS];
	const char *name = arguments[2];
	if (!strcmp(name, "mumps"))
		mumps(&s, x, factor, solve);
	else if (!strcmp(name, "umfpack"))
		umfpack(&s, x, factor, solve);
	else if (count == 4)
		pardiso(&s, arguments[3], !strcmp(name, "pardiso-single"), x, factor, solve);
	else
		return 2;
	double apart = 0, size = 0;
	for (int64_t k = 0; k < s.n; k++) {
		apart = fmax(apart, fabs(x[k] - s.other[k]));
		size = fmax(size, fabs(s.other[k]));
	}
	printf("%-15s %7ld nodes: factor %7.1f ms, solve %6.1f ms, apart %.0e\n", name, (long)(s.n / 3), median(factor),
	       median(solve), apart / size);
	return 0;
}
