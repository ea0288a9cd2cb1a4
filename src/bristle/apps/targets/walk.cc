// A function that XLA calls: it runs a function of the library of a friction model on the buffers.
#include <dlfcn.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "xla/ffi/api/ffi.h"

namespace ffi = xla::ffi;

using Function = int (*)(std::size_t, std::size_t, const double *const *, double *const *);

static ffi::Error run(std::string_view library, std::string_view symbol, std::int64_t lanes, std::int64_t steps, ffi::RemainingArgs arguments,
                      ffi::RemainingRets results)
{
    void *const loaded = dlopen(std::string(library).c_str(), RTLD_NOW | RTLD_LOCAL);
    const auto function = loaded ? reinterpret_cast<Function>(dlsym(loaded, std::string(symbol).c_str())) : nullptr;
    if (function == nullptr) {
        return ffi::Error(ffi::ErrorCode::kNotFound, "bristle cannot load the compiled friction model");
    }
    std::vector<const double *> in;
    std::vector<double *> out;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const auto buffer = arguments.get<ffi::Buffer<ffi::F64>>(i);
        if (!buffer.has_value()) {
            return buffer.error();
        }
        in.push_back(buffer->typed_data());
    }
    for (std::size_t i = 0; i < results.size(); ++i) {
        auto buffer = results.get<ffi::Buffer<ffi::F64>>(i);
        if (!buffer.has_value()) {
            return buffer.error();
        }
        out.push_back((*buffer)->typed_data());
    }
    const int result = function(static_cast<std::size_t>(lanes), static_cast<std::size_t>(steps), in.data(), out.data());
    dlclose(loaded);
    if (result == 1) {
        return ffi::Error(ffi::ErrorCode::kResourceExhausted, "the machine lacks memory for a walk of bristle");
    }
    return result == 0 ? ffi::Error::Success() : ffi::Error(ffi::ErrorCode::kInvalidArgument, "state: is not a state of this model");
}

XLA_FFI_DEFINE_HANDLER_SYMBOL(bristle_walk, run,
                              ffi::Ffi::Bind()
                                  .Attr<std::string_view>("library")
                                  .Attr<std::string_view>("symbol")
                                  .Attr<std::int64_t>("lanes")
                                  .Attr<std::int64_t>("steps")
                                  .RemainingArgs()
                                  .RemainingRets());
