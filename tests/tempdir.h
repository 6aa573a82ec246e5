/* A folder of a test's own in its working directory, named after the process, so that tests can run side by side. */
#pragma once
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

enum { TEMPDIR_LENGTH = 64, TEMPDIR_FILE = TEMPDIR_LENGTH + 32 };

/* dir: its name, prefix.process.number with the first number that is free. Nonzero when it cannot be made. */
static inline int TempDirMake(const char prefix[], char dir[TEMPDIR_LENGTH])
{
  int failed = -1;

  errno = EEXIST;
  for (int k = 0; failed && errno == EEXIST; k++) {
    snprintf(dir, TEMPDIR_LENGTH, "%s.%ld.%d", prefix, (long)getpid(), k);
    failed = mkdir(dir, 0700);
  }
  return failed;
}

/* And the name of a file in it */
static inline int TempDirFile(const char prefix[], const char name[], char dir[TEMPDIR_LENGTH], char file[TEMPDIR_FILE])
{
  const int failed = TempDirMake(prefix, dir);

  snprintf(file, TEMPDIR_FILE, "%s/%s", dir, name);
  return failed;
}

/* With the files in it. Nonzero when something stays. */
static inline int TempDirRemove(const char dir[])
{
  DIR *d = opendir(dir);
  struct dirent *e;

  if (!d) return -1;
  while ((e = readdir(d))) {
    char name[TEMPDIR_LENGTH + sizeof(e->d_name) + 1];

    snprintf(name, sizeof(name), "%s/%s", dir, e->d_name);
    if (e->d_name[0] != '.') unlink(name);
  }
  closedir(d);
  return rmdir(dir);
}
