#pragma once
// Deleter of what a C library gave: std::unique_ptr<X509, Freed<X509_free>>. Without a size of its
// own, other than a pointer to the function.

namespace driftwise {

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* held) const {
    Free(held);
  }
};

}  // namespace driftwise
