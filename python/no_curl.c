/* The functions of libcurl that HDF5 refers to; every one fails. */
#include <stddef.h>

enum { FAILED_INIT = 2 };

int curl_global_init(long flags);
void curl_global_cleanup(void);
void* curl_easy_init(void);
int curl_easy_setopt(void* curl, int option, ...);
int curl_easy_perform(void* curl);
void curl_easy_cleanup(void* curl);
void* curl_slist_append(void* list, const char* text);
void curl_slist_free_all(void* list);

int curl_global_init(long flags) { return (void)flags, FAILED_INIT; }
void curl_global_cleanup(void) {}
void* curl_easy_init(void) { return NULL; }
int curl_easy_setopt(void* curl, int option, ...) { return (void)curl, (void)option, FAILED_INIT; }
int curl_easy_perform(void* curl) { return (void)curl, FAILED_INIT; }
void curl_easy_cleanup(void* curl) { (void)curl; }
void* curl_slist_append(void* list, const char* text) { return (void)list, (void)text, NULL; }
void curl_slist_free_all(void* list) { (void)list; }
