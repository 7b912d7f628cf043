/* The one function of Windows' bcryptprimitives.dll that Rust's standard library calls, for Wine 8, which lacks the library. Tests only. */
#include <windows.h>
#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length)
{
    return RtlGenRandom(data, (ULONG)length);
}
