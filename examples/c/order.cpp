// Gives an order and prints its state: order INSTANCE "KIND NAME=VALUE ..." [OPERATOR].
#include <iostream>
#include <koseki.hpp>

int main(int count, char **arguments) try {
  if (count < 3) {
    std::cerr << "order INSTANCE \"KIND NAME=VALUE ...\" [OPERATOR]\n";
    return KOSEKI_ARGUMENT;
  }
  const auto state = koseki::order(arguments[1], arguments[2], count > 3 ? arguments[3] : "order");
  std::cout << "order " << state.number << ": " << reinterpret_cast<const char *>(state.text) << '\n';
  return state.status == KOSEKI_ORDER_STATUS_REFUSED;
} catch (const koseki::Error &error) {
  std::cerr << error.what() << '\n';
  return error.code;
}
